"""An action that draws regular polygons with turtle1."""
