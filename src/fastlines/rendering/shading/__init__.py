"""What a picture sees, and the lights that it is seen by."""
