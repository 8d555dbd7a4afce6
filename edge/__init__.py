"""What runs on the robot. Imports nothing from host/, firmware_sim/ or tools/."""
