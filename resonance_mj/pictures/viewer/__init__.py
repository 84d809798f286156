"""A saved run, or a simulation as it goes, in MuJoCo's interactive viewer."""
