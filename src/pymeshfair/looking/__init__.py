"""Looking at meshes without MeshLab's window: measures and comparison as data, pictures as functions of arrays."""
