"""``pymeshfair tune SCAN``: serves a page in the browser on which a recipe is tuned."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from .options import Json, recipe_names
from .streams import show


def tune(
    scan: Annotated[Path, Argument(metavar="SCAN", help="The mesh file to tune on; it is not changed.")],
    recipe: Annotated[
        str, Option(metavar="RECIPE", help="The recipe to start with: a name or an .mlx file.", autocompletion=recipe_names)
    ] = "smooth_implicit",
    port: Annotated[int, Option(help="Port to listen on; 0 takes a free one.", min=0, max=65535)] = 0,
    browser: Annotated[bool, Option("--browser/--no-browser", help="Whether to open the page in the browser.")] = True,
    json: Json = False,
) -> None:
    """Tune a recipe on a scan, on a page in the browser that shows the result of every change.

    Only this machine can open the page, by an address that contains a random token. Recipes and results are written to the
    working folder. Ctrl-C ends the command.
    """
    import secrets
    import socket
    import tempfile
    import webbrowser

    from ..errors import PymeshfairError, require_extra

    require_extra("tune", "websockets")
    from ..files.writing import staging_folder
    from ..recipe import load_recipe
    from ..tuning.bench import prepared_scan
    from ..tuning.server import redirecting_file, serve

    load_recipe(recipe)
    with staging_folder(Path(tempfile.gettempdir()) / "tuning") as folder:
        prepared = prepared_scan(scan.absolute())
        token = secrets.token_urlsafe(32)  # 256 bits
        try:
            listening = socket.create_server(("127.0.0.1", port))
        except OSError as error:
            raise PymeshfairError(f"cannot listen on port {port}: {error.strerror or error}") from error
        address = f"http://127.0.0.1:{listening.getsockname()[1]}/{token}/"

        def ready() -> None:
            show({"address": address}, [address, "Ctrl-C ends it."], json=json)
            if browser:
                webbrowser.open(redirecting_file(address, folder).as_uri())

        serve(prepared, recipe, token, folder, listening, ready=ready)
