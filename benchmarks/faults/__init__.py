"""`vizbot bench faults`: drives and missions while something goes wrong."""
