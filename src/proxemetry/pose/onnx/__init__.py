"""Back ends of ONNX networks, described by TOML specifications."""
