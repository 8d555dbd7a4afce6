"""Does the robot do on ARM what it does here? Evidence from an emulated processor; see tools/arm64_check.sh."""
