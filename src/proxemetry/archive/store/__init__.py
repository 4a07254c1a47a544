"""What lies in a results folder, and how it is read and written."""
