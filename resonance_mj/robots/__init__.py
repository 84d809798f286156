"""An MJCF file becomes an arm that the law can drive."""
