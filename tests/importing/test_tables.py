"""Tables as laboratories have them: twelve are imported right, others are refused with a line.

The tables are written after public ones: exports of testing machines in German, French, Spanish,
Chinese and Japanese, camera scripts, LabVIEW and Excel. Each is the same few readings, so that what
is right follows from how they are written here.
"""

from __future__ import annotations

import io
import math
import random
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import openpyxl
import pandas as pd
import pytest

from dolfingrip.cli.import_command import named
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.importing import importing
from dolfingrip.importing.header import DOUBTFUL, recognise
from dolfingrip.importing.importing import ImportedTable, understand
from dolfingrip.importing.told import Question, Told

PSI_KPA = 6.894757293168361
"""kPa per psi, from the international pound and inch."""


@dataclass
class LabTable:
    """A table and the columns that are right."""

    name: str
    content: bytes
    right: dict[str, list[float]]
    told: Told = field(default_factory=Told)
    experiment: str = "bending"


def sheet(rows: list[list[object]], *merged: str, percent: str = "") -> bytes:
    book = openpyxl.Workbook()
    book.create_sheet("Notes").append(["version 1.2.3", "of 3,4.5"])
    for row in rows:
        book.active.append(row)
    for area in merged:
        book.active.merge_cells(area)
    for cell in book.active[percent] if percent else ():
        cell.number_format = "0.0%"
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


GERMAN = """Prüfprotokoll Nr. 17;;
Bediener;Müller;
Zeit [s];Druck [bar];Biegewinkel [°]
0,0;0,000;0,0
0,5;0,125;3,42
1,0;0,250;7,91
"""
FRENCH = """Temps (s)\tPression (mbar)\tForce de contact (mN)
0,0\t0\t0
1,0\t150\t1 234,5
2,0\t300\t2 470
"""
SPANISH = """Alargamiento (mm);Carga (N);Probeta
0,00;0,00;A
1,65;0,42;A
3,30;0,81;A
0,00;0,00;B
1,65;0,40;B
"""
CHINESE = """时间(秒),压力(千帕),弯曲角(度)
0,0,0
1,20,5.5
2,40,12.25
"""
JAPANESE = """時間（秒）,圧力（ＭＰａ）,曲げ角度（度）
0,0.000,0.0
1,0.025,6.1
2,0.050,13.4
"""
CAMERA = """% tracked by a script
Frame,Pressure (psi),ActuatorAngle_deg
10,0.0,-1.2
40,2.9,-6.1
70,5.8,-11.0
"""
MACHINE = """"Test","Tension 3"
"Date","2023-05-04"

"Time","Extension","Load"
"(sec)","(in)","(lbf)"
"0.00","0.000","0.00"
"0.10","0.100","0.52"
"0.20","0.200","0.97"
"""
TRELOAR = """# Treloar 1944, simple extension
# lambda   nominal stress (kgf/cm2)
1.00  0.00
1.12  1.40
1.24  2.35
1.39  3.20
"""
TRELOAR_KG = """Extension ratio,Nominal stress (kg/cm²)
1.00,0
1.12,1.40
1.24,2.35
"""
ITALIAN = """Prova n° 3 - dita soffice
Tempo [s];Pressione [psi];Angolo [gradi]
0;0,0;0
1;2,9;4,9
"""
IMAGES = """Image n°\tPression (bar)\tAngle de flexion (degrés)
1\t0\t0
26\t0,2\t9,1
"""
RADIANS = """time_ms|p_kPa|theta_rad
0|0|0
500|12.5|0.1
1000|25|0.25
"""
RAW = """t [s];ADC counts pressure;Winkel [Grad]
0.0;410;0
0.5;820;4.5
1.0;1230;9.75
"""
VACUUM = """sep=;
Uhrzeit;Unterdruck [mbar];Winkel [°]
10:00:00;0;0
10:00:05;-200;4,1
10:00:12;-400;8,3
"""
MIDNIGHT = """Clock,Pressure (mmHg),Angle (deg)
11:59:50 PM,0,0
11:59:55 PM,75,3.2
12:00:10 AM,150,6.9
"""
DATED = """Datum;Druck [Pa];Kraft [gf]
11.03.2024 14:00:05;0;0
11.03.2024 14:00:10;25'000;51,2
11.03.2024 14:00:15;50'000;1'236
"""
MINUTES = """Time (min),Pressure (cmH2O),Angle (deg)
0:00,0,0
0:30,100,3.2
1:15,200,6.9
"""
KOREAN = """실험 7;;
시간;압력;굽힘각
0 초;0 kPa;0 도
1 초;20 kPa;5,5 도
2 초;40 kPa;12,25 도
"""
RUSSIAN = """Время, с;Давление, кПа;Сила, мН
0;0;0
1;20;1 234,5
2;40;−25
Среднее;20;403,2
"""
PAGES = """Data Acquisition: Timed
Time\tAxial Displacement\tAxial Force
s\tmm\tN
1764252185.125\t0.000\t0.00
1764252185.250\t0.100\t0.52

Data Acquisition: Timed
Time\tAxial Displacement\tAxial Force
s\tmm\tN
1764252185.375\t0.200\t0.97
"""
LABVIEW = """LabVIEW Measurement\t
Samples\t3\t3
Y_Unit_Label\tbar\tdeg\t
Delta_X\t1.000000\t1.000000
***End_of_Header***\t\t\t
X_Value\tPressure\tAngle\tComment
0.000000\t0.000000\t0.000000\t
1.000000\t0.200000\t5.500000\t
2.000000\t0.400000\tOL\t
"""
TURKISH = """Deney 4;;
Zaman (sn);Basınç (bar);Açı (derece)
0,0;0,000;0,0
0,5;0,125;3,42
"""
SERIAL = """Starting...
14:03:05.120 -> P: 0.0 kPa, Angle: 0.0 deg
14:03:05.620 -> P: 12.3 kPa, Angle: 5.2 deg
14:03:06.120 -> P: 950 Pa, Angle: 9 deg
"""
ZWICK = """Dehnung;Zugspannung
%;MPa
0;0,0
10;0,2
"""
DIADEM = """Channelname\tZeit\tDruck\tWinkel
Unit\ts\t10³ Pa\t°
Description\t\tSensor 1\tKamera
Length\t2\t2\t2
\t0\t0,0\t0
\t1\t0,2\t5
"""
ROS = """%time,field.pressure_kPa,field.angle_deg,field.header.seq
1764252185125000000,0.0,0,17
1764252185625000000,12.5,5,18
"""
SCATTER = """Timestamp,Mean pressure (kPa),SD pressure (kPa),Mean angle (deg),Std (deg)
2026-11-27T14:03:05.125Z,0,0.1,0,0.2
2026-11-27T14:03:06.125Z,20,0.3,5,0.5
"""
GAUGES = """Temps;Pression;Angle;Unité
min;bar relatif;;
0;0;0;°
0,5;250 mbar(g);0,1;rad
1;0,5;12;°
"""
MERGED = [
    ["Finger 7"],
    [],
    ["Zeitpunkt", "Druck", "Winkel"],
    [None, "kPa", "°"],
    *([datetime(2026, 11, 27, 14, 3, 5 + i), 20 * i, 5.5 * i] for i in range(3)),
    ["Mittelwert", 20, 5.5],
    ["größter", 40, 11],
]
ABOVE = [
    ["Finger 7", None, None],
    ["Zeit", "Aktor 1", None],
    [None, "Druck", "Winkel"],
    ["s", "bar", "°"],
    *([i, f"0,{i}25", 5.5 * i] for i in range(3)),
    [3, 0.5, "#N/A"],
]
STRESS = [
    ["Uniaxial tension", None, None],
    ["Dehnung", "Nennspannung", "Bemerkung"],
    ["%", "kPa", None],
    [0, 0, None],
    [20, 151.7, "slow"],
    [40, 266.9, None],
]

TABLES = (
    LabTable(
        "midnight.csv", MIDNIGHT.encode("utf-16"),
        {"time_s": [0, 5, 20], "pressure_kPa": [0, 9.9991776, 19.998355],
         "angle_deg": [0, 3.2, 6.9]},
    ),
    LabTable(
        "dated.csv", DATED.encode("utf-8-sig"),
        {"time_s": [0, 5, 10], "pressure_kPa": [0, 25, 50],
         "force_N": [0, 0.0512 * 9.80665, 1.236 * 9.80665]},
        experiment="blocked_force",
    ),
    LabTable(
        "minutes.csv", MINUTES.encode(),
        {"time_s": [0, 30, 75], "pressure_kPa": [0, 9.80665, 19.6133], "angle_deg": [0, 3.2, 6.9]},
    ),
    LabTable(
        "german.csv", GERMAN.encode("latin-1"),
        {"time_s": [0, 0.5, 1], "pressure_kPa": [0, 12.5, 25], "angle_deg": [0, 3.42, 7.91]},
    ),
    LabTable(
        "french.txt", FRENCH.encode("utf-8-sig"),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 15, 30], "force_N": [0, 1.2345, 2.47]},
        experiment="blocked_force",
    ),
    LabTable(
        "spanish.csv", SPANISH.encode(),
        {"displacement_mm": [0, 1.65, 3.3, 0, 1.65], "force_N": [0, 0.42, 0.81, 0, 0.4]},
        Told(gauge_length=33.0, area=9.0, rate=2.5), "coupon",
    ),
    LabTable(
        "chinese.csv", CHINESE.encode("gbk"),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 20, 40], "angle_deg": [0, 5.5, 12.25]},
    ),
    LabTable(
        "japanese.csv", JAPANESE.encode("shift_jis"),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 25, 50], "angle_deg": [0, 6.1, 13.4]},
    ),
    LabTable(
        "camera.csv", CAMERA.encode(),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 2.9 * PSI_KPA, 5.8 * PSI_KPA],
         "angle_deg": [0, 4.9, 9.8]},
        Told(column=named(("ActuatorAngle_deg*-1=angle_deg",)), zero_at_rest=True, frame_rate=30.0),
    ),
    LabTable(
        "machine.csv", MACHINE.encode("utf-16"),
        {"time_s": [0, 0.1, 0.2], "displacement_mm": [0, 2.54, 5.08],
         "force_N": [0, 0.52 * 4.4482216152605, 0.97 * 4.4482216152605]},
        Told(gauge_length=50.0, area=15.0), "coupon",
    ),
    LabTable(
        "treloar.dat", TRELOAR.encode(),
        {"stretch": [1, 1.12, 1.24, 1.39], "stress_MPa": [0, 0.137293, 0.230456, 0.313813]},
        Told(column=named(("column 1=stretch", "column 2=stress [kgf/cm2]"))), "coupon",
    ),
    LabTable(
        "treloar.csv", TRELOAR_KG.encode("latin-1"),
        {"stretch": [1, 1.12, 1.24], "stress_MPa": [0, 0.1372931, 0.2304563]},
        experiment="coupon",
    ),
    LabTable(
        "italian.csv", ITALIAN.encode("latin-1"),
        {"time_s": [0, 1], "pressure_kPa": [0, 2.9 * PSI_KPA], "angle_deg": [0, 4.9]},
    ),
    LabTable(
        "images.txt", IMAGES.encode("cp1252"),
        {"time_s": [0, 1], "pressure_kPa": [0, 20], "angle_deg": [0, 9.1]},
        Told(frame_rate=25.0),
    ),
    LabTable(
        "radians.psv", RADIANS.encode(),
        {"time_s": [0, 0.5, 1], "pressure_kPa": [0, 12.5, 25],
         "angle_deg": [0, math.degrees(0.1), math.degrees(0.25)]},
    ),
    LabTable(
        "raw.csv", RAW.encode(),
        {"time_s": [0, 0.5, 1], "pressure_kPa": [0, 20, 40], "angle_deg": [0, 4.5, 9.75]},
        Told(column=named(("ADC counts pressure*0.04878048780487805-20=pressure_kPa",))),
    ),
    LabTable(
        "vacuum.csv", VACUUM.encode("cp1252"),
        {"time_s": [0, 5, 12], "pressure_kPa": [0, -20, -40], "angle_deg": [0, 4.1, 8.3]},
    ),
    LabTable(
        "korean.csv", KOREAN.encode("cp949"),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 20, 40], "angle_deg": [0, 5.5, 12.25]},
    ),
    LabTable(
        "russian.csv", RUSSIAN.encode("cp1251", "replace").replace(b"?", b"-"),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 20, 40], "force_N": [0, 1.2345, -0.025]},
        Told(column=named(("Сила, мН=force_mN",))), "blocked_force",
    ),
    LabTable(
        "pages.txt", PAGES.encode(),
        {"time_s": [0, 0.125, 0.25], "displacement_mm": [0, 0.1, 0.2], "force_N": [0, 0.52, 0.97]},
        Told(gauge_length=50.0, area=15.0), "coupon",
    ),
    LabTable(
        "labview.lvm", LABVIEW.encode(),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 20, 40], "angle_deg": [0, 5.5, math.nan]},
        Told(column=named(("X_Value=time_s",))),
    ),
    LabTable(
        "turkish.csv", TURKISH.encode("cp1254"),
        {"time_s": [0, 0.5], "pressure_kPa": [0, 12.5], "angle_deg": [0, 3.42]},
    ),
    LabTable(
        "serial.log", SERIAL.encode(),
        {"time_s": [0, 0.5, 1], "pressure_kPa": [0, 12.3, 0.95], "angle_deg": [0, 5.2, 9]},
    ),
    LabTable(
        "zwick.csv", ZWICK.encode("latin-1"), {"strain": [0, 0.1], "stress_MPa": [0, 0.2]},
        experiment="coupon",
    ),
    LabTable(
        "diadem.txt", DIADEM.encode("latin-1"),
        {"time_s": [0, 1], "pressure_kPa": [0, 0.2], "angle_deg": [0, 5]},
    ),
    LabTable(
        "ros.csv", ROS.encode(),
        {"time_s": [0, 0.5], "pressure_kPa": [0, 12.5], "angle_deg": [0, 5]},
        Told(column=named(("time=time_ns",))),
    ),
    LabTable(
        "scatter.csv", SCATTER.encode(),
        {"time_s": [0, 1], "pressure_kPa": [0, 20], "angle_deg": [0, 5]},
    ),
    LabTable(
        "above.xlsx", sheet(ABOVE, "A1:C1", "A2:A3", "B2:C2"),
        {"time_s": [0, 1, 2, 3], "pressure_kPa": [2.5, 12.5, 22.5, 50],
         "angle_deg": [0, 5.5, 11, math.nan]},
    ),
    LabTable(
        "percent.xlsx",
        sheet([["Strain", "Stress [MPa]"], [0, 0], [0.1, 0.2]], percent="A"),
        {"strain": [0, 0.1], "stress_MPa": [0, 0.2]},
        experiment="coupon",
    ),
    LabTable(
        "gauges.csv", GAUGES.encode(),
        {"time_s": [0, 30, 60], "pressure_kPa": [0, 25, 50],
         "angle_deg": [0, math.degrees(0.1), 12]},
    ),
    LabTable(
        "spread.csv", "p [kPa];Winkel [°]\n0 ± 0,5;0,5 ± 0,3\n10+/-0,5;4,5 ± 0,3 °\n".encode(),
        {"pressure_kPa": [0, 10], "angle_deg": [0.5, 4.5]},
    ),
    LabTable(
        "merged.xlsx", sheet(MERGED),
        {"time_s": [0, 1, 2], "pressure_kPa": [0, 20, 40], "angle_deg": [0, 5.5, 11]},
    ),
    LabTable(
        "stress.xlsx", sheet(STRESS),
        {"strain": [0, 0.2, 0.4], "stress_MPa": [0, 0.1517, 0.2669]},
        experiment="coupon",
    ),
)  # fmt: skip


def imported(table: LabTable, folder: Path) -> ImportedTable:
    file = folder / table.name
    file.write_bytes(table.content)
    return understand(file, table.told)


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_a_table_whose_units_are_told_is_imported_right(table: LabTable, tmp_path: Path) -> None:
    found = imported(table, tmp_path)
    assert not found.questions
    assert found.setup["experiment"] == table.experiment
    csv, toml = importing.write(found, tmp_path / "out")
    written = pd.read_csv(csv)
    assert set(written.columns) - {"specimen"} == set(table.right)
    supplied = found.setup.get("cavity", {}).get("cavity", {}).get("pressure_ratio", 1.0)
    written["pressure_kPa"] = supplied * written.get("pressure_kPa", math.nan)
    for name, values in table.right.items():
        assert written[name].tolist() == pytest.approx(values, rel=1e-5, abs=1e-9, nan_ok=True), (
            name
        )
    comments = [text for text in toml.read_text(encoding="utf-8").splitlines() if text[:1] == "#"]
    for name in table.right:
        assert any(text.startswith(f"# {name} ") for text in comments), name


@pytest.mark.parametrize(
    "name",
    ["Half bending angle [deg]", "theta_FEM [deg]", "AngleSim [deg]", "Halbwinkel [°]",
     "Winkelfehler [°]", "Druckabweichung [kPa]", "Force calc. [N]", "Reibkraft [N]",
     "Lateral force [N]", "仿真角度 [deg]", "角度误差 [deg]", "각도 오차 [deg]",
     "Angle théorique [°]"],
)  # fmt: skip
def test_the_name_of_another_number_than_a_reading_is_asked_about(name: str) -> None:
    found = recognise(name)
    assert (found.readings, found.why) == ((), DOUBTFUL)
    assert found.offered


@pytest.mark.parametrize(
    "name",
    ["Tip bending angle [deg]", "Angle exp. [deg]", "Standardkraft [N]", "Kraftsensor [N]",
     "Blocking force [N]", "Contact force [N]", "弯曲角度 [deg]", "Max. force [N]"],
)  # fmt: skip
def test_a_reading_may_have_other_words_in_its_name(name: str) -> None:
    assert len(recognise(name).readings) == 1


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("Zeit [s];Druck;Winkel [°]\n0;0;0\n1;0,5;2\n", ['--column "Druck=pressure_bar"']),
        ("t [s],p [kPa],angle\n0,0,0\n1,5,0.2\n", ['--column "angle=angle_rad"']),
        ("t;p [kPa];angle [°]\n0;0;0\n1;1,500;2\n2;2,500;3\n", ['--decimal "."', '--decimal ","']),
        ("t [s],p [bara],angle [°]\n0,1,0\n1,1.5,2\n", ['--column "p [bara]-1.0132=pressure_bar"']),
        ("p;angle\nkPa abs;°\n101;0\n150;2\n", ['--column "p [kPa abs]-101.33=pressure_kPa"']),
        ("t;p;angle\ns;kPa foo;°\n0;1;0\n1;2;2\n", ['--column "p [kPa foo]*FACTOR=pressure_kPa"']),
        ("s,p [kPa],angle SD [°]\n0,0,0\n1,2,3\n", ['--column "angle SD [°]=angle_deg"']),
        ("s,p [kPa] x10,angle [°]\n0,0,0\n1,2,3\n", ['--column "p [kPa] x10=pressure_kPa"']),
        ("s,p [x10 kPa],angle [°]\n0,0,0\n1,2,3\n", ['--column "p [x10 kPa]*FACTOR=pressure_kPa"']),
        ("s,p [kPa],angle [°]\n0,101.2,0\n1,150,2\n", ['--column "p [kPa]-101.2=pressure_kPa"']),
        ("t [s],p [kPa],angle [°]\n0,0,5\n1,50,12\n", ["--zero-at-rest", "--no-zero-at-rest"]),
        ("t [s],p [kPa],angle [°]\n0,0,0\n1,50,-12\n", ['--column "angle [°]*-1=angle_deg"']),
        ("t,p [V],angle [°]\n0,0,0\n1,50,12\n", ['--column "p [V]*FACTOR+OFFSET=pressure_kPa"']),
        ("Frame,p [kPa],angle [°]\n0,0,0\n1,50,12\n", ["--frame-rate VALUE", "--rate VALUE"]),
        ("p1 [kPa],p [bar],angle [°]\n0,0,0\n1,50,12\n", ['--column "p [bar]=pressure_kPa"']),
        ("p [kPa],angle [°],p [kPa]\n0,0,0\n1,2,4\n", ['--column "p [kPa] #3=pressure_kPa"']),
        ("t [s],p [kPa],angle [grad]\n0,0,0\n1,2,4\n", ['--column "angle [grad]*0.9=angle_deg"']),
        ("strain [%],stress [MPa]\n100,0\n120,0.2\n", ['--column "strain [%]=stretch"']),
        ("stretch [%],stress [MPa]\n0,0\n20,0.2\n", ['--column "stretch [%]=strain"']),
        ("Dehnung,Spannung [MPa]\n0,0\n1,0.2\n", ['--column "Dehnung=strain_%"']),
        ("strain,stress_mpa\n0,0\n1,0.2\n", ['--column "stress_mpa*1=stress_MPa"']),
        ("t [s],p [kPa],angle [°],force [N]\n0,0,0,0\n1,50,12,1\n", ["--experiment bending"]),
        ("Weg [mm];Kraft [N]\n0,5;0\n1,5;2\n", ["--gauge-length VALUE", "--area VALUE"]),
        ("t [s],x [kPa],angle [°]\n0,0,0\n1,50,12\n", ['--column "x [kPa]=pressure_kPa"']),
        ("t,p [kPa],x [°]\n1764252185125000000,0,0\n1764252185625000000,5,12\n",
         ['--column "t=time_ns"', '--column "t=time_ms"']),
        ("p [mPa],angle [°]\n0,0\n0.05,12\n", ['--column "p [mPa]*1000=pressure_kPa"']),
        ("p [inWG],angle [°]\n0,0\n0.5,12\n", ['--column "p [inWG]*FACTOR=pressure_kPa"']),
        ("t [s],p [%],angle [°]\n0,0,0\n1,5,12\n", ['--column "p [%]*FACTOR=pressure_kPa"']),
        ("t [s],p [kPa],angle [°]\n0:00,0,0\n0:30,5,12\n", ['--column "t [s]=time_min"']),
        ("T,p [bar],x [°]\n3/4/26 9:00:00,0,0\n4/4/26 9:00:00,1,2\n", ['--column "T=time_dmy"']),
        ("One\np [bar],angle [°]\n0,0\n1,2\nTwo\np [bar],angle [°]\n0,0\n1,3\n", ["--sheet One"]),
    ],
)  # fmt: skip
def test_two_readings_of_a_column_are_refused_with_the_line_to_add(
    text: str, lines: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "lab.csv"
    file.write_text(text, encoding="utf-8")
    try:
        questions = understand(file, Told()).questions
    except Question as question:
        questions = [question]
    offered = {str(option): question for question in questions for option in question.options}
    assert {*lines} <= {*offered}, offered
    # each line settles its question
    for line in lines:
        option = next(option for option in offered[line].options if str(option) == line)
        for place, number in (("VALUE", 2.0), ("FACTOR", 1.5), ("OFFSET", 0.0)):
            option = option.filled(place, number) if place in str(option) else option
        try:
            left = understand(file, Told().with_option(option)).questions
        except Question as question:
            left = [question]
        assert offered[line].text not in {question.text for question in left}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\nhello,world\n", "no table in it; allowed: "),
        ("t [s],p [kPa],angle [°]\n0,0,0\n1,x,3\n2,5,6\n", "line 3: p [kPa] = x: not a number"),
        ("t [s],p [kPa],angle [°]\n0,0,0\n1,2\n2,5,6,9\n3,6,7\n", "line 4: 4 entries"),
        ("Image,p [kPa],angle [°]\na,0,0\nb,2,3\n", 'or add --column "Image=ignore"'),
        ("t [s],p [kPa]\n0,0\n1,2\n", "allowed: pressure and an angle"),
        ("t [s],p [kPa],angle [°]\n0,0,-\n1,2,-\n", "or without numbers: angle [°]"),
        ("t [s],vacuum [kPa],angle [°]\n0,-40,0\n1,50,3\n", "suction and pressure in one table"),
        ("lambda,true stress [MPa]\n1,0\n2,3\n", "allowed: "),
        ("p [kPa];angle [°]\n0;0,5\n5;2.5\n", "lab.csv: its numbers have points and commas"),
        ("t [s],p [kPa],angle [°]\n0,0,0\nvalve,1,2\n1,2,3\n", "remove a line that is no reading"),
    ],
)
def test_what_is_no_table_of_a_measurement_is_one_line(
    text: str, said: str, tmp_path: Path
) -> None:
    file = tmp_path / "lab.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as error:
        understand(file, Told())
    assert said in str(error.value)
    assert "\n" not in str(error.value)


NAMES = {
    "cp1252": [("Zeit", "Druck", "Biegewinkel"), ("Temps", "Pression", "Angle"),
               ("Tiempo", "Presión", "Ángulo"), ("Time", "Pressure", "Bend angle")],
    "gb18030": [("时间", "气压", "弯曲角度")],
    "cp932": [("時間", "圧力", "曲げ角")],
}  # fmt: skip
UNITS = (
    {"s": 1.0, "ms": 1e-3, "min": 60.0},
    {"kPa": 1.0, "bar": 100.0, "mbar": 0.1, "MPa": 1e3, "psi": PSI_KPA, "kgf/cm2": 98.0665},
    {"°": 1.0, "deg": 1.0, "rad": math.degrees(1.0)},
)
"""Units and what they are in s, kPa and degrees."""


def test_random_tables_are_imported_right_or_not_at_all(tmp_path: Path) -> None:
    seed = random.randrange(2**32)
    print(f"seed {seed}")
    draw = random.Random(seed)
    unsure = []
    for number in range(60):
        encoding = draw.choice([*NAMES])
        names = draw.choice(NAMES[encoding])
        units = [draw.choice([*each]) for each in UNITS]
        if encoding != "cp1252" and units[2] == "°":
            units[2] = "度"
        separator = draw.choice(",;\t|")
        decimal = "." if separator == "," else draw.choice(".,")
        form = draw.choice(["{} [{}]", "{} ({})", "{} / {}", "{}_{}", "{}, {}"])
        header = [form.format(*each) for each in zip(names, units, strict=True)]
        step = [draw.uniform(0.5, 3.0) for _ in range(3)]
        rows = [[i**power * each for each in step] for power in [draw.uniform(1, 2)]
                for i in range(5)]  # fmt: skip
        digits = draw.randrange(2, 6)
        cells = [[f"{each:.{digits}f}".replace(".", decimal) for each in row] for row in rows]
        text = "\r\n".join(
            separator.join(f'"{each}"' if separator in each else each for each in row)
            for row in [header, *cells]
        )
        file = tmp_path / f"{number}.csv"
        file.write_bytes(text.encode(draw.choice([encoding, "utf-8", "utf-16"])))
        try:
            found = understand(file, Told())
        except Question:
            unsure.append(digits)
            continue
        if found.questions:
            assert "begins at" in str(found.questions[0]), (found.questions[0], text)
            continue
        for k, name in enumerate(("time_s", "pressure_kPa", "angle_deg")):
            factor = {**UNITS[k], "度": 1.0}[units[k]]
            right = [factor * round(row[k], digits) for row in rows]
            assert found.table[name].tolist() == pytest.approx(right, rel=1e-9), text
    assert set(unsure) <= {3}  # 1.234 may be a thousand


def test_nominal_strain_and_stress_are_fitted_as_they_were_before(tmp_path: Path) -> None:
    table = TABLES[-1]
    csv, _ = importing.write(imported(table, tmp_path), tmp_path / "out")
    (series,) = coupons.read(csv)
    assert series.mode == "uniaxial"
    assert series.stretch == pytest.approx([1, 1.2, 1.4])
    assert series.stress_MPa == pytest.approx([0, 0.1517, 0.2669])
    long = understand(tmp_path / table.name, Told(gauge_length=20.0, area=4.0, rate=1.0))
    csv, _ = importing.write(long, tmp_path / "whole")
    (again,) = coupons.read(csv)
    assert again.stretch == pytest.approx(series.stretch)
    assert again.stress_MPa == pytest.approx(series.stress_MPa)


def test_the_set_up_beside_a_table_is_taken_along(tmp_path: Path) -> None:
    table = next(each for each in TABLES if each.name == "vacuum.csv")
    (tmp_path / "vacuum.toml").write_text('note = "hung"\n[finger]\nwall_mm = 1.8\n')
    _, toml = importing.write(imported(table, tmp_path), tmp_path / "out")
    text = toml.read_text(encoding="utf-8")
    assert "wall_mm = 1.8" in text
    assert 'note = "hung"' in text


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ("experiment = 3", r"vacuum\.toml: experiment = 3: allowed: a name"),
        ('experiment = "bending"\nrate_kPa_per_s = "x"', "rate_kPa_per_s = x: allowed: at least"),
        ('[coupon]\nwidth_mm = "x"', r"vacuum\.toml: coupon\.width_mm = .x.: not a number"),
        ("[specimen.B]\nwall_mm = 1.8", r"vacuum\.toml: \[specimen\.B\]: not in the CSV"),
        ("[noise]\nangle_deg = -1.0", r"noise\.angle_deg = -1\.0: allowed: at least 0"),
    ],
)
def test_a_set_up_that_diagnose_would_refuse_is_refused(
    told: str, said: str, tmp_path: Path
) -> None:
    table = next(each for each in TABLES if each.name == "vacuum.csv")
    (tmp_path / "vacuum.toml").write_text(told, encoding="utf-8")
    with pytest.raises(ConfigError, match=said):
        importing.write(imported(table, tmp_path), tmp_path / "out")
    assert not (tmp_path / "out").exists()
