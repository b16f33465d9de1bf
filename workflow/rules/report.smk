# What is made of all cases together.

STATUS = expand(list(rules.evaluate.output), case=RUNS)
"""Last status files of all cases."""


rule picture:
    input:
        cases=STATUS,
    output:
        picture=report(f"{ROOT}/picture{PART}.png", category="screening"),
    params:
        cases=CASES,
        code=CODE,
    log:
        f"{LOGS}/picture{PART}.log",
    script:
        "../scripts/picture.py"


rule movie:
    input:
        status=f"{ROOT}/{{case}}/status/vtk.json",
    output:
        video=f"{ROOT}/{{case}}/movie.mp4",
        loop=f"{ROOT}/{{case}}/movie.webp",
    params:
        code=CODE,
    log:
        f"{LOGS}/{{case}}/movie.log",
    script:
        "../scripts/movie.py"


rule report:
    input:
        cases=STATUS,
        picture=rules.picture.output.picture,
        template=str(place("workflow") / "report" / "report.html.j2"),
    output:
        report=report(f"{ROOT}/report{PART}.html", category="screening"),
        numbers=f"{ROOT}/report{PART}.json",
    params:
        config=str(CONFIG),
        content=content(CONFIGURED),
        code=CODE,
        cases=list(CASES.values()),
        comparisons=COMPARISONS,
        scale=SCALE,
        # runs of other seeds beside those of the workflow are no input, but a reason to draw their band
        seeds=lambda wildcards: sorted(
            {str(p.parent) for run in RUNS for p in Path(ROOT).glob(f"{run}-*/summary.json")} - {f"{ROOT}/{run}" for run in RUNS}
        ),
    log:
        f"{LOGS}/report{PART}.log",
    script:
        "../scripts/report.py"


rule verdict:
    input:
        cases=STATUS,
        report=rules.report.output.report,
    output:
        verdict=f"{ROOT}/verdict{PART}.txt",
    params:
        cases=list(CASES),
        runs=list(RUNS),
    log:
        f"{LOGS}/verdict{PART}.log",
    script:
        "../scripts/verdict.py"
