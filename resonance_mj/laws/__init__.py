"""The equations of the controller, their memory, and the laws made of them."""
