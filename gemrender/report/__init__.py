"""Tables, files and pictures for people."""
