"""The law inside MuJoCo's own loop: its control callback, compiled or interpreted."""
