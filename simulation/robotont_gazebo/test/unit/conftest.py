"""Tests of pictures hold for the compiled steps of the renderer and for numpy."""
import pytest

from robotont_gazebo.core import native


@pytest.fixture(name='each_renderer', params=['compiled', 'numpy'])
def _each_renderer(request, monkeypatch):
    if request.param == 'numpy':
        monkeypatch.setattr(native, 'library', None)
