"""Experiments through MuJoCo's integrator."""
