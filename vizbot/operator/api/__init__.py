"""The operator's HTTP and WebSocket API, and the server behind it."""
