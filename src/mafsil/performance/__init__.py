"""Velocity kinematics, statics, singularities, manipulability and workspace of arms."""
