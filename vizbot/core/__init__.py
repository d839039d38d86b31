"""The vocabulary that every part of vizbot shares: types, protocols, errors, geometry."""
