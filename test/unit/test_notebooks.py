"""The notebooks in docs: they run from top to bottom, and are kept without outputs."""
import pathlib

import nbclient
import nbformat
import pytest

pytestmark = pytest.mark.slow

DOCS = pathlib.Path(__file__).resolve().parents[2] / 'docs'
NOTEBOOKS = sorted(DOCS.glob('*.ipynb'))
CELL_TIMEOUT = 120  # [s]; the slowest takes 3


@pytest.fixture(scope='module', params=NOTEBOOKS, ids=[path.name for path in NOTEBOOKS])
def notebook(request):
    return nbformat.read(request.param, nbformat.NO_CONVERT)


def test_notebook_is_valid_and_kept_without_outputs(notebook):
    nbformat.validate(notebook)
    assert [cell for cell in notebook.cells if cell.get('outputs') or cell.get('execution_count')] == []


@pytest.mark.nightly
def test_every_cell_runs(notebook, tmp_path, monkeypatch):
    monkeypatch.setenv('IPYTHONDIR', str(tmp_path))
    monkeypatch.setenv('JUPYTER_RUNTIME_DIR', str(tmp_path))
    nbclient.NotebookClient(notebook, timeout=CELL_TIMEOUT, resources={'metadata': {'path': str(DOCS)}}).execute()
    printed = ''.join(output.get('text', '') for cell in notebook.cells for output in cell.get('outputs', ()))
    pictures = [output for cell in notebook.cells for output in cell.get('outputs', ())
                if 'image/svg+xml' in output.get('data', {})]
    assert 'reached the goal: True' in printed and len(pictures) == 1
    # 64 when this was written: the last line says how many goals the learned policy reaches
    assert int(printed.rpartition('\n')[0].rpartition('\n')[2].split()[0]) >= 50, printed


def test_there_is_a_notebook():
    assert NOTEBOOKS
