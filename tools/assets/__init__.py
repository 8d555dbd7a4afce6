"""Furniture of Sweet Home 3D: read its libraries, render the models, make the furniture pack of the simulator."""
