"""Springs: what one exerts, what it may be, and the best ones for a torque along a motion."""
