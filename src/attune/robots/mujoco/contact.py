"""Who can touch whom: bits for MuJoCo's contact filter, shared by robot, furniture and objects.

Two geoms meet when the `contype` of one is in the `conaffinity` of the other. Furniture never meets furniture, and
within one arm, and within the robot's trunk, nothing can meet.
"""

FURNITURE = 1
OBJECT = 2
TRUNK = 4
RIGHT_ARM = 8
LEFT_ARM = 16

VISUAL_GROUP = 2
"""Geoms of this group are only looked at: they touch nothing."""
