"""The readers and writers: a module for each format, and what several of them share."""
