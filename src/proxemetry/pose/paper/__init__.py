"""The source paper's pair of networks: YOLOv4 for people and OpenPose BODY_25 for their joints."""
