"""The compiled steps of the renderer, of native/; their documentation is in _native.pyi."""
try:
    from sim_scene._native import Background, Camera, Image, Light, Pattern, Pose, Response, Scene, Solid
except ImportError as error:
    raise ImportError(f'the compiled part of sim_scene cannot be loaded: {error}; build it with ./run build or '
                      'catkin_make, and source the devel/setup.bash of that workspace') from error

__all__ = ['Background', 'Camera', 'Image', 'Light', 'Pattern', 'Pose', 'Response', 'Scene', 'Solid']
