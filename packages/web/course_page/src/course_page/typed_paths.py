"""Paths as users type them, below the only folder that an editor shows."""
import os


def below(root: str, path: str) -> str:
    """Return a path of JupyterLab as one below ``root``; raise ValueError if it is not below it.

    ``path`` is below it already, or begins with ~, or is one of the whole disk, whose first slash JupyterLab removes.
    """
    path, home = path.strip('/'), os.path.expanduser('~')
    first = path.partition('/')[0]
    if first == '~':
        whole = home + path[1:]
    elif os.path.lexists(os.path.join(root, first)) or not any(
            f'/{path}/'.startswith(folder.rstrip('/') + '/') for folder in (root, home)):
        return path
    else:
        whole = f'/{path}'
    if f'{whole}/'.startswith(home.rstrip('/') + '/'):  # which may be a link
        whole = os.path.realpath(home) + whole[len(home.rstrip('/')):]
    relative = os.path.relpath(whole, root)
    if relative.partition('/')[0] == '..':
        raise ValueError(f'{path} is not below {root}, the only folder that is shown here: --folder ~ shows your own')
    return '' if relative == '.' else relative
