"""Mistakes in what a picture says of its own error: audit, repair, batch means, checks, certificate."""

from __future__ import annotations

from tests.mutants.sin import Sin, device

REPAIR = "tests/kernels/test_majorant_repair.py"
CERTIFICATE = "tests/kernels/test_certificate.py"
CHECKS = "tests/kernels/test_checks.py"

SINS = (
    Sin(
        "a violated majorant is not counted",
        device("core/audit.h"),
        "a->violations -= violated;",
        "",
        (REPAIR,),
    ),
    Sin(
        "the weight of violations is not summed",
        device("core/audit.h"),
        "a->touched += pick((real)0.f, throughput, violated);",
        "a->touched = pick((real)0.f, throughput, violated);",
        (REPAIR,),
    ),
    Sin(
        "the small loop's densities stay as they were under a raised majorant",
        device("repair.py"),
        '"volume_grid": "relative"',
        '"volume_none": "relative"',
        (REPAIR,),
    ),
    Sin(
        "what was repaired counts as broken",
        device("render.py"),
        "found = replace(again, repaired",
        "found = replace(found, repaired",
        (REPAIR,),
    ),
    Sin(
        "launches weigh the same, whatever they hold",
        device("batches.py"),
        "apart**2 * share * self.samples",
        "apart**2 * share",
        (CERTIFICATE,),
    ),
    Sin(
        "what launches share goes unseen",
        device("certificate.py"),
        "if score > STANDARD_ERRORS:",
        "if score > 1e9:",
        (CERTIFICATE,),
    ),
    Sin(
        "one device's evidence stands for all",
        device("certificate.py"),
        "if len(drifts) < len(uses):",
        "if not drifts:",
        (CERTIFICATE,),
    ),
    Sin(
        "a check passes whatever it finds",
        device("checks.py"),
        '"passed" if off <= limit else "failed", "deviation"',
        '"passed", "deviation"',
        (f"{CHECKS}::test_a_wrong_program_breaks_a_law",),
    ),
    Sin(
        "a law is asked of another program",
        device("checks.py"),
        "if own and not is_own(laid_out(changed, read)):",
        "if False:",
        (f"{CHECKS}::test_nothing_is_said_of_another_program",),
    ),
)
