"""Reads, validates and generates documents of MaterialX.

    materialx.py FOLDER

Writes NAME.vert, NAME.frag (GLSL) and NAME.osl beside each NAME.mtlx of the folder. Exits with 1 if a document is not
valid, or no code can be generated for it. Needs the package MaterialX 1.39.
"""

import pathlib
import shutil
import sys

import MaterialX as mx
from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenOsl, PyMaterialXGenShader


def context(generator):
    own = PyMaterialXGenShader.GenContext(generator)
    own.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    return own


def main(folder):
    libraries = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), libraries)
    glsl_generator = PyMaterialXGenGlsl.VkShaderGenerator.create()
    osl_generator = PyMaterialXGenOsl.OslShaderGenerator.create()
    glsl = context(glsl_generator)
    glsl.pushUserData("udbinding", PyMaterialXGenGlsl.GlslResourceBindingContext.create(0, 0))
    glsl.getOptions().hwMaxActiveLightSources = 0
    osl = context(osl_generator)
    include = mx.getDefaultDataSearchPath().find("libraries/stdlib/genosl/include")
    for header in pathlib.Path(include.asString()).glob("*.h"):
        shutil.copy(header, folder)
    failed = False
    for path in sorted(folder.glob("*.mtlx")):
        document = mx.createDocument()
        mx.readFromXmlFile(document, str(path))
        # A document must be valid with the standard nodes that it uses.
        document.setDataLibrary(libraries)
        valid, message = document.validate()
        if not valid:
            print(f"{path.name}: {message}")
            failed = True
            continue
        [material] = document.getMaterialNodes()
        [shader] = mx.getShaderNodes(material)
        try:
            for generator in (glsl_generator, osl_generator):
                generator.registerTypeDefs(document)
            stages = glsl_generator.generate(path.stem, shader, glsl)
            path.with_suffix(".vert").write_text(stages.getSourceCode(PyMaterialXGenShader.VERTEX_STAGE))
            path.with_suffix(".frag").write_text(stages.getSourceCode(PyMaterialXGenShader.PIXEL_STAGE))
            # The node alone: OSL as it is generated for the surface needs closures.
            node = shader.getConnectedNode("emission_color")
            stages = osl_generator.generate(path.stem, node, osl)
            # Its includes lie beside it.
            path.with_suffix(".osl").write_text(stages.getSourceCode(PyMaterialXGenShader.PIXEL_STAGE))
        except Exception as error:
            print(f"{path.name}: {error}")
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
