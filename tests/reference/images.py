"""Images for reference.py: language 1.4, textures, and the maps of environments.  Pillow reads PNG, OpenEXR reads EXR."""
import math


def texels(path):
    """The linear texels of an OpenEXR file, in rows from the top."""
    import OpenEXR
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return [list(zip(*(row.astype(float).tolist() for row in rows))) for rows in zip(*(channels[c].pixels for c in 'RGB'))]


class Texture:
    def __init__(self, path):
        import numpy as np
        if path.endswith('.png'):
            from PIL import Image
            coded = np.asarray(Image.open(path).convert('RGB'), float) / 255
            self.rows = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)      # sRGB, IEC 61966-2-1
        elif path.endswith('.exr'):
            self.rows = np.array(texels(path))
        else:
            raise ValueError(path)
        self.rows = self.rows[::-1].tolist()     # from the bottom: (0, 0) is the lower left corner
        self.height, self.width = len(self.rows), len(self.rows[0])

    def __call__(self, u, v):
        """Repeated; between the middles of texels the mean of four, weighted (bilinear)."""
        u, v = (x if math.isfinite(x) else 0.0 for x in (u, v))
        x, y = u * self.width - 0.5, v * self.height - 0.5
        i, j = math.floor(x), math.floor(y)
        s, t = x - i, y - j
        total = (0.0, 0.0, 0.0)
        for row, a in ((j, 1 - t), (j + 1, t)):
            for column, b in ((i, 1 - s), (i + 1, s)):
                texel = self.rows[row % self.height][column % self.width]
                total = tuple(sum_ + a * b * x for sum_, x in zip(total, texel))
        return total


def white(u, v):
    return (1.0, 1.0, 1.0)
