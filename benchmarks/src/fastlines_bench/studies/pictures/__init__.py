"""How long pictures take, and how soon the first one is there."""
