"""What runs and plans show: expectations, certificates, comparison, inspection."""
