"""What the tool is to follow, and the joint motion behind it."""
