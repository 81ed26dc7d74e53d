"""What is shown of round brilliants only: their proportions, their labelled vertices and their triangles."""
