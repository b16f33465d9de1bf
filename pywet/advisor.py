"""Time step advisor (placeholder)."""
from pywet.scene import Scene
def refuse_unstable(scene: Scene) -> None:
    """Nothing yet."""
