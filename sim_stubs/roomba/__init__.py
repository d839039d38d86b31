"""A simulated Roomba that answers Open Interface bytes on a serial line."""
