"""What elements and questions are held against: background phrases, and a bank of pictures."""
