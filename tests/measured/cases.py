"""The measured recordings, what must be seen on each, and why a miss is a miss."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rotorwise.datasets import Metadata
from rotorwise.datasets.metadata import parse_gears
from rotorwise.diagnose import Analysis

HERE = Path(__file__).resolve().parent
DATA = HERE.parents[2] / "shared" / "data"

Check = Callable[[Analysis], bool]


@dataclass(frozen=True)
class Case:
    """One analysis: file, sidecar, baseline, further metadata, what is expected in words and as a check."""

    name: str
    file: str
    sidecar: str
    expected: str
    check: Check
    baseline: str | None = None
    metadata: Metadata | None = None
    explanation: str = ""

    @property
    def path(self) -> Path:
        """The recording."""
        return DATA / self.file


def probability(analysis: Analysis, fault: str) -> float:
    """Return the stated probability of a fault, 0 when it is not found."""
    return next((one.probability for one in analysis.findings if one.fault == fault), 0.0)


def first(fault: str) -> Check:
    """Expect a fault in the first place, above 50 %."""
    return lambda analysis: (
        bool(analysis.findings) and analysis.findings[0].fault == fault and analysis.findings[0].probability > 0.5
    )


def nothing_above(limit: float, *allowed: str) -> Check:
    """Expect no finding above a probability, but for the allowed ones."""
    return lambda analysis: all(one.probability <= limit or one.fault in allowed for one in analysis.findings)


def silent(analysis: Analysis) -> bool:
    """Expect no finding at all."""
    return not analysis.findings


def best_line(analysis: Analysis, prefix: str) -> float:
    """Return the largest signal-to-noise ratio of the evidence lines whose names start so."""
    return max(
        (line.signal_to_noise for one in analysis.findings for line in one.lines if line.name.startswith(prefix)),
        default=0.0,
    )


def _cwru() -> list[Case]:
    folder = "05_cwru_bearing/data/"
    return [
        Case(
            "CWRU IR007",
            folder + "12k_Drive_End_IR007_0_105.mat",
            "cwru",
            "inner race first, BPFI signal-to-noise > 50",
            lambda a: first("bearing_inner_race")(a) and best_line(a, "1 x BPFI") > 50,
        ),
        Case(
            "CWRU OR007@6",
            folder + "12k_Drive_End_OR007@6_0_130.mat",
            "cwru",
            "outer race first",
            first("bearing_outer_race"),
        ),
        Case(
            "CWRU OR014@6",
            folder + "12k_Drive_End_OR014@6_0_197.mat",
            "cwru",
            "outer race first, or honestly weak",
            lambda a: first("bearing_outer_race")(a) or nothing_above(0.3)(a),
            explanation="The BPFO line stands out of the noise but modulates its best band by about 15 %, no "
            "deeper than a healthy bearing's own: below the limit of what is shown.",
        ),
        Case(
            "CWRU B007",
            folder + "12k_Drive_End_B007_0_118.mat",
            "cwru",
            "ball first, or honestly weak",
            lambda a: first("bearing_ball")(a) or nothing_above(0.3)(a),
            explanation="2BSF is not visible (see the card); cage and outer-race lines are faint.",
        ),
        Case("CWRU normal (48 kHz)", folder + "normal_0_97.mat", "cwru", "nothing", silent),
    ]


def _mfpt() -> list[Case]:
    return [
        Case(
            f"MFPT {kind} {number}",
            f"06_mfpt_bearing/data/{kind}RaceFault_vload_{number}.mat",
            "mfpt",
            f"{kind.lower()} race first",
            first(f"bearing_{kind.lower()}_race"),
        )
        for kind in ("Inner", "Outer")
        for number in (1, 7)
    ]


ADI = "01_adi_limerick_mfs/data/"
ADI_SPEEDS = ("1200", "1800", "2400")
IMBALANCE = ("VLIL", "LImL", "HImL", "VHIL")  # in rising order


def adi(speed: str, bearing: str = "GoB", shaft: str = "GS", load: str = "BaLo", alignment: str = "WA") -> str:
    """Return the name of an ADI file."""
    return f"{ADI}{speed}_{bearing}_{shaft}_{load}_{alignment}_00lb.Wfm.csv"


def _adi() -> list[Case]:
    cases = []
    for speed in ADI_SPEEDS:
        healthy = adi(speed)
        cases.append(
            Case(
                f"ADI {speed} healthy",
                healthy,
                "adi_limerick",
                "nothing above 50 % without baseline",
                nothing_above(0.5),
            )
        )
        for load in IMBALANCE:
            cases.append(
                Case(
                    f"ADI {speed} imbalance {load}",
                    adi(speed, load=load),
                    "adi_limerick",
                    "unbalance first",
                    first("unbalance"),
                    baseline=healthy,
                )
            )
        for what, file in (("misaligned", adi(speed, alignment="MA")), ("bent shaft", adi(speed, shaft="BS"))):
            fault = "misalignment" if what == "misaligned" else "bent_shaft"
            for baseline in (None, healthy):
                label = "" if baseline is None else ", baseline"
                cases.append(
                    Case(
                        f"ADI {speed} {what}{label}",
                        file,
                        "adi_limerick",
                        "evidence or not evident, no wrong name above 50 %",
                        nothing_above(0.5, fault),
                        baseline=baseline,
                        explanation="Not evident: 1X to 3X barely move, and the sensor was re-mounted (see the card).",
                    )
                )
    for bearing, fault in (
        ("HOR", "bearing_outer_race"),
        ("HIR", "bearing_inner_race"),
        ("LIR", "bearing_inner_race"),
    ):
        words = f"{fault.split('_')[1]} race first"
        cases.append(Case(f"ADI 1800 {bearing}", adi("1800", bearing=bearing), "adi_limerick", words, first(fault)))
    cases.append(
        Case(
            "ADI 1800 HBF",
            adi("1800", bearing="HBF"),
            "adi_limerick",
            "ball first, or honestly weak",
            lambda a: first("bearing_ball")(a) or nothing_above(0.5)(a),
            explanation="Only the cage rhythm shows (2 FTF); ball and cage defects both make it, and both are named.",
        )
    )
    return cases


def gear0_seen(analysis: Analysis) -> bool:
    """Expect speed, mesh and the wheel's sidebands of the Gear0 rig."""
    speed = analysis.speed
    if speed is None or abs(speed.speed_hz - 33.33) > 0.02:
        return False
    wheel = any("16.67 Hz round" in text and "46-tooth" in text for text in analysis.remarks)
    mesh = any("round 766.6 Hz" in text or "round 1533." in text for text in analysis.remarks)
    return mesh and wheel and nothing_above(0.5)(analysis)


def _gears() -> list[Case]:
    cases = [
        Case(
            f"Gear0 channel {channel}",
            f"03_gear0_gearbox_28ch/data/3027_217_Data_Chan{channel}.mat",
            "gear0",
            "33.33 Hz, mesh 766.6 Hz, 16.67 Hz sidebands of the wheel",
            gear0_seen,
        )
        for channel in (5, 11, 12, 14)
    ]
    gear = Metadata(rate_hz=12_800.0, gears=parse_gears("32"))
    for load in ("0", "50"):
        folder = "08_gfs_gearbox_broken_tooth/data/"
        cases.append(
            Case(
                f"Gearbox 08 broken, {load} % load, 12.8 kHz assumed",
                f"{folder}b30hz{load}.csv.gz",
                "gfs_gearbox",
                "grown sidebands against healthy",
                lambda a: any(one.fault.startswith("gear_") for one in a.findings[:1]),
                baseline=f"{folder}h30hz{load}.csv.gz",
                metadata=gear,
                explanation="First and wider sidebands grew alike, on one channel of four and less at load: tooth "
                "fault, wear and run-out share a weak probability.",
            )
        )
    return cases


def _at_rest() -> list[Case]:
    return [
        Case(
            "Machine off",
            "12_sqv_machine_off/REC3603_ch2.txt",
            "sqv_machine_off",
            "not turning, no finding",
            lambda a: silent(a) and "not turning" in a.verdict,
        )
    ]


def cases() -> list[Case]:
    """Return all cases, in the order of the table."""
    return [*_cwru(), *_mfpt(), *_adi(), *_gears(), *_at_rest()]
