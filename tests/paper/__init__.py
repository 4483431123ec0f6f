"""The paper's figures against ours: `python -m tests.paper` makes the tables and pictures, ten minutes; `--write`.

variants   what could make the paper's numbers, each as a run; what is measured of it
figures    docs/paper.png, docs/paper-variants.png
__main__   docs/measurements/paper.md
"""
