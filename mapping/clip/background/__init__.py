"""Background phrases and a bank of pictures, with which elements and questions are compared."""
