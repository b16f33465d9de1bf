# The stages of one case. The declared output of a stage is its status file, because a failed case has nothing else; what it
# makes besides is listed in docs/results.md. Simulations have priority: the short evaluations then fill all cores to the end.


rule scene:
    input:
        fingerprint=lambda wildcards: fingerprint(wildcards.case),
    output:
        status=f"{ROOT}/{{case}}/status/scene.json",
    params:
        config=str(CONFIG),
        number=lambda wildcards: RUNS[wildcards.case][0],
        preset=lambda wildcards: RUNS[wildcards.case][1],
        scale=SCALE,
        engine=ENGINE,
        seed=lambda wildcards: RUNS[wildcards.case][2],
    priority: 2
    log:
        f"{LOGS}/{{case}}/scene.log",
    script:
        "../scripts/scene.py"


rule simulate:
    input:
        scene=rules.scene.output.status,
    output:
        status=f"{ROOT}/{{case}}/status/simulate.json",
    params:
        ranks=CHOSEN.ranks,
        engine=ENGINE,
    log:
        f"{LOGS}/{{case}}/simulate.log",
    threads: CHOSEN.ranks
    priority: 1
    resources:
        mem_mb=job_memory("simulate"),
        mem_mb_per_cpu=core_memory,
        runtime=job_minutes,
    script:
        "../scripts/simulate.py"


rule evaluate:
    input:
        simulate=rules.simulate.output.status,
    output:
        results=f"{ROOT}/{{case}}/status/results.json",
        replay=f"{ROOT}/{{case}}/status/replay.json",
        vtk=f"{ROOT}/{{case}}/status/vtk.json",
    params:
        code=sources.digest_of_evaluation(),
        # a preset for the sake of comparison has no laws of the user's own
        second=lambda wildcards: {} if RUNS[wildcards.case][1] else dict(CONFIGURED.settings.laws.reference),
        said=lambda wildcards: "" if RUNS[wildcards.case][1] else reference_word(CONFIGURED.settings.laws.reference),
    log:
        f"{LOGS}/{{case}}/evaluate.log",
    resources:
        mem_mb=job_memory("replay"),
    script:
        "../scripts/evaluate.py"
