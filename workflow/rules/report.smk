# What is made of all cases together.


rule picture:
    input:
        cases=expand(rules.vtk.output.status, case=CASES),
    output:
        picture=f"{ROOT}/picture.png",
    params:
        cases=CASES,
    log:
        f"{LOGS}/picture.log",
    script:
        "../scripts/picture.py"


rule report:
    input:
        cases=expand(rules.vtk.output.status, case=CASES),
        picture=rules.picture.output.picture,
        template="workflow/report/report.html.j2",
        config=CONFIG_FILES,
    output:
        report=f"{ROOT}/report.html",
    params:
        cases=list(CASES.values()),
        scale=SCALE,
    log:
        f"{LOGS}/report.log",
    script:
        "../scripts/report.py"


rule verdict:
    input:
        cases=expand(rules.vtk.output.status, case=CASES),
        report=rules.report.output.report,
    output:
        verdict=f"{ROOT}/verdict.txt",
    params:
        cases=list(CASES),
    log:
        f"{LOGS}/verdict.log",
    script:
        "../scripts/verdict.py"
