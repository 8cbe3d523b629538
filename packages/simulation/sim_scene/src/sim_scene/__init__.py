"""World files and the renderer that draws them, without ROS.

* ``worlds.load_world`` finds and reads a world by its name or file: YAML, or SDF by ``sdf`` with its ``meshes``.
* ``renderer.Renderer`` makes colour and depth images of a world; ``native`` has its compiled steps, ``textures`` its
  patterns, ``response`` the camera's gamma.
"""
