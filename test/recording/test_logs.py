"""Logs of anybody's sensors: each layout that programs write, made from a simulated run."""
# mypy: ignore-errors

from __future__ import annotations

import sqlite3
import zipfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import simulate
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.logs import Log, read_log

G = 9.80665
RUN = simulate(
    "hand", duration=1.5, imu_rate=50.0, magnetometer_rate=50.0, sensor_grade="mems", epoch_ns=1_700_000_000_000_000_000
)
T = RUN.imu.t_ns
GYRO, ACC, MAG = RUN.imu.gyro, RUN.imu.specific_force, RUN.magnetometer.field
DEG = np.degrees(GYRO)
VERTICAL = np.array([0.1, -0.2, 9.8]) + np.zeros_like(ACC)
SINCE_S = (T - T[0]) / 1e9
TEXTS = ["there"] * len(T)
Make = Callable[[Path], Path]


def cells(columns: Iterable[object]) -> list[list[str]]:
    """Rows of texts: arrays of several axes are as many columns, numbers are exact."""
    found: list[list[str]] = []
    for column in columns:
        array = np.asarray(column)
        for part in array.T.tolist() if array.ndim == 2 else [array.tolist()]:
            found.append([each if isinstance(each, str) else repr(each) for each in part])
    return [list(row) for row in zip(*found, strict=True)]


def write(
    path: Path, header: str | None, columns: Sequence[object], *, separator: str = ",", comma: bool = False, **how: str
) -> Path:
    lines = [separator.join(row) for row in cells(columns)]
    lines = [line.replace(".", ",") for line in lines] if comma else lines
    path.parent.mkdir(parents=True, exist_ok=True)
    text = "\n".join([*([] if header is None else [header]), *lines]) + "\n"
    path.write_bytes(text.encode(how.get("encoding", "utf-8")))
    return path


def turned(vectors: np.ndarray) -> np.ndarray:
    """Axes in the order z, y, x."""
    return vectors[:, ::-1]


def zipped(folder: Path) -> Path:
    path = folder.with_suffix(".zip")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, f"{folder.name}/{file.name}")
    return path


def axes(before: str, after: str = "", names: str = "xyz", separator: str = ",") -> str:
    return separator.join(f"{before}{axis}{after}" for axis in names)


def sensor_logger(path: Path) -> Path:
    header = "time,seconds_elapsed,z,y,x"
    write(path / "log" / "Gyroscope.csv", header, [T, SINCE_S, turned(GYRO)])
    write(path / "log" / "Accelerometer.csv", header, [T, SINCE_S, turned(ACC - VERTICAL)])
    write(path / "log" / "TotalAcceleration.csv", header, [T, SINCE_S, turned(ACC)])
    write(path / "log" / "Gravity.csv", header, [T, SINCE_S, turned(VERTICAL)])
    write(path / "log" / "MagnetometerUncalibrated.csv", header, [T, SINCE_S, turned(MAG * 2e6)])
    write(path / "log" / "Magnetometer.csv", header, [T, SINCE_S, turned(MAG * 1e6)])
    write(path / "log" / "Orientation.csv", "time,seconds_elapsed,qz,qy,qx,qw,roll,pitch,yaw", [T, SINCE_S, *[T] * 7])
    (path / "log" / "Metadata.csv").write_text("version,device name\n3,phone\n")
    return path / "log"


def sensor_logger_without_total(path: Path) -> Path:
    folder = sensor_logger(path)
    (folder / "TotalAcceleration.csv").unlink()
    return folder


def sensor_logger_in_capitals(path: Path) -> Path:
    header = "time,seconds_elapsed," + axes("ACCELEROMETER ", " (m/s²)", "ZYX")
    write(path / "a" / "TotalAcceleration.csv", header, [T, SINCE_S, turned(ACC)])
    header = "time,seconds_elapsed," + axes("GYROSCOPE ", " (rad/s)", "ZYX")
    write(path / "a" / "Gyroscope.csv", header, [T, SINCE_S, turned(GYRO)])
    header = "time,seconds_elapsed," + axes("MAGNETIC FIELD ", " (\u03bcT)", "ZYX")
    write(path / "a" / "Magnetometer.csv", header, [T, SINCE_S, turned(MAG * 1e6)])
    return path / "a"


def phyphox(path: Path) -> Path:
    def header(name: str, unit: str) -> str:
        return ",".join(
            f'"{cell}"' for cell in ["Time (s)", *(f"{name} {axis} ({unit})" for axis in "xyz"), "Absolute"]
        )

    size = np.linalg.norm(ACC, axis=1)
    write(path / "p" / "Gyroscope.csv", header("Gyroscope", "rad/s"), [SINCE_S, GYRO, size])
    write(path / "p" / "Accelerometer.csv", header("Acceleration", "m/s^2"), [SINCE_S, ACC, size])
    write(path / "p" / "Linear Acceleration.csv", header("Linear Acceleration", "m/s^2"), [SINCE_S, 0 * ACC, size])
    write(path / "p" / "Magnetometer.csv", header("Magnetic field", "\u00b5T"), [SINCE_S, MAG * 1e6, size])
    return zipped(path / "p")


def phyphox_with_commas(path: Path) -> Path:
    def header(unit: str) -> str:
        return ";".join(f'"{cell}"' for cell in ["Time (s)", *(f"{axis} ({unit})" for axis in "XYZ")])

    how = {"separator": ";", "comma": True}
    write(path / "q" / "Gyroscope.csv", header("rad/s"), [SINCE_S, GYRO], **how)
    write(path / "q" / "Acceleration with g.csv", header("m/s²"), [SINCE_S, ACC], **how)
    write(path / "q" / "Linear Acceleration.csv", header("m/s²"), [SINCE_S, 0 * ACC], **how)
    write(path / "q" / "Magnetometer.csv", header("µT"), [SINCE_S, MAG * 1e6], encoding="latin-1", **how)
    return path / "q"


def x_io(path: Path) -> Path:
    header = "Time (s)," + ",".join(
        axes(f"{name} ", f" ({unit})", "XYZ")
        for name, unit in [("Gyroscope", "deg/s"), ("Accelerometer", "g"), ("Magnetometer", "uT")]
    )
    header += ",Barometer (hPa),Quaternion W,Quaternion X,Quaternion Y,Quaternion Z"
    return write(path / "x.csv", header, [SINCE_S, DEG, ACC / G, MAG * 1e6, *[SINCE_S] * 5])


def x_imu3(path: Path) -> Path:
    us = (T - T[0]) // 1000
    header = "Timestamp (us)," + axes("Gyroscope ", " (deg/s)", "XYZ") + "," + axes("Accelerometer ", " (g)", "XYZ")
    write(path / "x" / "Inertial.csv", header, [us, DEG, ACC / G])
    write(path / "x" / "Magnetometer.csv", "Timestamp (us),X (a.u.),Y (a.u.),Z (a.u.)", [us, MAG])
    return path / "x"


def euroc(path: Path) -> Path:
    header = "#timestamp [ns]," + axes("w_RS_S_", " [rad s^-1]") + "," + axes("a_RS_S_", " [m s^-2]")
    return write(path / "data.csv", header, [T, GYRO, ACC])


def px4(path: Path) -> Path:
    us = (T - T[0]) // 1000
    header = "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative"
    header += ",accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt"
    zero = 0 * T
    write(path / "u" / "f_sensor_combined_0.csv", header, [us, GYRO, zero + 4000, zero, ACC, zero + 4000])
    header = "timestamp,timestamp_sample,device_id,magnetometer_ga[0],magnetometer_ga[1],magnetometer_ga[2],x"
    write(path / "u" / "f_vehicle_magnetometer_0.csv", header, [us + 40, us, zero, MAG * 1e4, zero])
    header = "timestamp,q[0],q[1],q[2],q[3],delta_q_reset[0]"
    write(path / "u" / "f_vehicle_attitude_0.csv", header, [us, *[SINCE_S] * 5])
    return path / "u"


def sensor_log(path: Path) -> Path:
    header = "loggingTime(txt),locationTimestamp_since1970(s),accelerometerTimestamp_sinceReboot(s),"
    header += axes("accelerometerAcceleration", "(G)", "XYZ") + ",gyroTimestamp_sinceReboot(s),"
    header += axes("gyroRotation", "(rad/s)", "XYZ") + ",motionTimestamp_sinceReboot(s),"
    header += axes("motionRotationRate", "(rad/s)", "XYZ") + "," + axes("motionUserAcceleration", "(G)", "XYZ") + ","
    header += axes("motionGravity", "(G)", "XYZ") + "," + axes("motionMagneticField", "(µT)", "XYZ")
    late = SINCE_S // 1 + 1.7e9
    columns = [TEXTS, late, SINCE_S, -ACC / G, SINCE_S, GYRO, SINCE_S, 0 * GYRO, 0 * ACC, 0 * ACC, MAG * 1e6]
    return write(path / "s.csv", header, columns)


def andro_sensor(path: Path) -> Path:
    header = ";".join(
        axes(name, f" ({unit})", "XYZ", ";")
        for name, unit in [
            ("ACCELEROMETER ", "m/s²"),
            ("GRAVITY ", "m/s²"),
            ("LINEAR ACCELERATION ", "m/s²"),
            ("GYROSCOPE ", "rad/s"),
            ("MAGNETIC FIELD ", "μT"),
        ]
    )
    header += ";LOCATION Satellites in range;Time since start in ms ;YYYY-MO-DD HH-MI-SS_SSS"
    ms = (T - T[0]) // 10**6
    columns = [
        ACC,
        VERTICAL,
        ACC - VERTICAL,
        GYRO,
        MAG * 1e6,
        ["3 / 4"] * len(T),
        ms,
        ["2024-01-01 10-11-12_123"] * len(T),
    ]
    file = write(path / "a.csv", header, columns, separator=";")
    lines = file.read_text().splitlines()
    lines.insert(5, ";" * 14 + ";3 / 4;70;2024-01-01 10-11-12_123")
    file.write_text("\n".join(lines))
    return file


def vmu931(path: Path, header: str | None = "Attribute,Time stamp,x,y,z") -> Path:
    ms = (T - T[0]) // 10**6 + 411_480
    for name, values in (("gyroscope", DEG), ("accelerometer", ACC / G), ("magnetometer", MAG * 1e6)):
        write(path / "v" / f"{name}s.csv", header, [[name] * len(T), ms, values])
    return path / "v"


def physics_toolbox(path: Path) -> Path:
    columns = [SINCE_S, ACC / G, GYRO, MAG * 1e6]
    return write(path / "t.csv", "time,gFx,gFy,gFz,wx,wy,wz,Bx,By,Bz", columns)


def physics_toolbox_with_clock(path: Path) -> Path:
    clock = [
        f"09:{1 + ms // 60_000:02d}:{ms // 1000 % 60:02d},{ms % 1000:03d}" for ms in ((T - T[0]) // 10**6).tolist()
    ]
    columns = [clock, ACC / G, GYRO, MAG * 1e6]
    return write(path / "t.csv", "time;gFx;gFy;gFz;wx;wy;wz;Bx;By;Bz", columns, separator=";", comma=True)


def xsens(path: Path, per_ms: int = 10) -> Path:
    header = "// Start Time: 2024\n// Sample rate: 50.0Hz\nPacketCounter\tSampleTimeFine\t"
    header += "\t".join(axes(name, "", "XYZ", "\t") for name in ("Acc_", "FreeAcc_", "Gyr_", "Mag_")) + "\tQuat_q0"
    fine = ((T - T[0]) // 10**6 * per_ms + 2**32 - 5000) % 2**32
    columns = [np.arange(len(T)), fine, ACC, 0 * ACC, GYRO, MAG, SINCE_S]
    return write(path / "x.txt", header, columns, separator="\t")


def sketch(path: Path) -> Path:
    ms = (T - T[0]) // 10**6
    return write(path / "m.csv", "timestamp_ms,ax,ay,az,gx,gy,gz,mx,my,mz", [ms, ACC, GYRO, MAG])


def sketch_in_words(path: Path) -> Path:
    ms = (T - T[0]) // 10**6
    header = "Timestamp," + axes("Accel", "", "XYZ") + "," + axes("Gyro", "", "XYZ") + "," + axes("Mag", "", "XYZ")
    return write(path / "m.csv", header, [ms, ACC, GYRO, MAG], encoding="utf-8-sig")


def sketch_with_units(path: Path) -> Path:
    us = (T - T[0]) // 1000
    header = "t_us," + axes("a", "_g") + "," + axes("g", "_deg_s") + "," + axes("m", "_gauss")
    return write(path / "m.csv", header, [us, ACC / G, DEG, MAG * 1e4])


def sketch_with_underscores(path: Path) -> Path:
    header = "time," + axes("accel_") + "," + axes("gyro_") + ",temperature"
    return write(path / "m.csv", header, [SINCE_S, ACC, GYRO, SINCE_S], separator=",")


def betaflight(path: Path) -> Path:
    us = (T - T[0]) // 1000
    header = "loopIteration, time (us), gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2]"
    return write(path / "b.csv", header, [np.arange(len(T)), us, DEG, ACC], separator=", ")


def plot_juggler(path: Path) -> Path:
    header = "__time," + axes("/imu/data_raw/angular_velocity/") + "," + axes("/imu/data_raw/linear_acceleration/")
    header += "," + axes("/imu/data_raw/orientation/", "", "wxyz") + "," + axes("/mag/magnetic_field/")
    lines = [header]
    for t, imu, field in zip(T, cells([GYRO, ACC, *[SINCE_S] * 4]), cells([MAG]), strict=True):
        time = f"{t / 1e9:.9f}"
        lines += [",".join([time, *imu, "", "", ""]), ",".join([time, *[""] * 10, *field])]
    path = path / "j.csv"
    path.write_text("\n".join(lines))
    return path


def rostopic(path: Path) -> Path:
    header = "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
    header += axes("field.orientation.", "", "xyzw") + "," + axes("field.orientation_covariance", "", "0123") + ","
    header += axes("field.angular_velocity.") + "," + axes("field.angular_velocity_covariance", "", "012") + ","
    header += axes("field.linear_acceleration.")
    columns = [T, 0 * T, T, TEXTS, *[SINCE_S] * 8, GYRO, 0 * GYRO, ACC]
    return write(path / "r.csv", header, columns)


def px4_with_other_topics(path: Path) -> Path:
    folder = px4(path)
    us = (T - T[0]) // 1000
    write(folder / "f_sensor_mag_0.csv", "timestamp,device_id,x,y,z", [us, us, 0 * MAG])
    write(folder / "f_vehicle_local_position_0.csv", "timestamp,x,y,z,ax,ay,az", [us, 0 * MAG, 0 * MAG])
    write(folder / "f_estimator_states_0.csv", "timestamp,gyro_bias[0],gyro_bias[1],gyro_bias[2]", [us, 0 * MAG])
    return folder


def own_bag(path: Path) -> Path:
    RUN.to_bag(path / "own.mcap")
    return path / "own.mcap"


def sqlite(path: Path, split: int = 1) -> Path:
    """The bag of the run as ROS 2 Humble records it."""
    contents = BagFiles(own_bag(path)).contents(lambda topic, kind: True)
    folder = path / "rosbag2"
    folder.mkdir()
    rows = [
        (number, time, payload)
        for number, track in enumerate(contents.tracks.values(), 1)
        for time, payload in contents.messages(track.key).payloads()
    ]
    rows.sort(key=lambda row: row[1])
    for part in range(split):
        with sqlite3.connect(folder / f"rosbag2_{part}.db3") as bag:
            bag.execute(
                "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
                "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)"
            )
            bag.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
            for number, track in enumerate(contents.tracks.values(), 1):
                bag.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, track.topic, track.message_type))
            own = rows[part * len(rows) // split : (part + 1) * len(rows) // split]
            bag.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", own)
        bag.close()
    return folder


ROWS: list[tuple[Make, str]] = [
    (sensor_logger, "TotalAcceleration.csv"),
    (lambda path: zipped(sensor_logger(path)), "TotalAcceleration.csv"),
    (sensor_logger_without_total, "is without gravity, which is added"),
    (sensor_logger_in_capitals, "in m/s²"),
    (phyphox, "converted to T"),
    (phyphox_with_commas, "Acceleration with g.csv"),
    (x_io, "converted to rad/s"),
    (x_imu3, "no known unit"),
    (euroc, "in ns"),
    (px4, "in µs by its"),
    (px4_with_other_topics, "converted to T"),
    (sensor_log, "opposite"),
    (andro_sensor, "Time since start in ms"),
    (vmu931, "VMU931"),
    (lambda path: vmu931(path, None), "VMU931"),
    (physics_toolbox, "Physics Toolbox"),
    (physics_toolbox_with_clock, "a time of day"),
    (xsens, "begins anew"),
    (lambda path: xsens(path, 1000), "begins anew"),
    (sketch, "no unit is given"),
    (sketch_in_words, "in ms by its steps"),
    (sketch_with_units, "gauss"),
    (sketch_with_underscores, "in s by its steps"),
    (betaflight, "Betaflight"),
    (plot_juggler, "in s by its size"),
    (rostopic, "in ns by its size"),
    (own_bag, "/imu/data_raw"),
    (sqlite, "/imu/data_raw"),
    (lambda path: sqlite(path, 3), "/imu/data_raw"),
]


def require_readings(log: Log) -> None:
    """Compare a log with the run that it is made of."""
    for found, wanted in ((log.gyro, GYRO), (log.accelerometer, ACC), (log.magnetometer, MAG)):
        if found is not None:
            assert found.values == pytest.approx(wanted, rel=1e-12, abs=1e-12)
            step = found.t_ns - found.t_ns[0] - (T - T[0])
            assert np.abs(step).max() <= 200


@pytest.mark.parametrize(("make", "told"), ROWS)
def test_logs_of_each_layout_are_read(make: Make, told: str, tmp_path: Path) -> None:
    log = read_log(make(tmp_path))
    require_readings(log)
    assert log.accelerometer is not None
    assert told in " ".join(log.taken)


@pytest.mark.parametrize("make", [sensor_logger, phyphox, own_bag, sketch, px4])
def test_a_log_with_a_magnetometer_has_one(make: Make, tmp_path: Path) -> None:
    assert read_log(make(tmp_path)).magnetometer is not None


HEADER = "t,gx,gy,gz,ax,ay,az"
LINES = [",".join(row) for row in cells([SINCE_S, GYRO, ACC])]


def text(*lines: str) -> Make:
    return lambda path: write_text(path / "log.csv", "\n".join(lines))


def write_text(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("when,p,q,r,u,v,w", {"t": "when:s", "gyro_x": "p:deg/s", "gyro_y": "q:deg/s", "gyro_z": "r:deg/s"}),
        ("when,p,q,r,ax,ay,az", {"t": 1, "gyro_x": "2:deg/s", "gyro_y": "3:deg/s", "gyro_z": "4:deg/s"}),
        (None, {"t": "1", "gyro_x": "2:deg/s", "gyro_y": "3:deg/s", "gyro_z": "4:deg/s"}),
        ("t,gx,gy,gz,a:x,a:y,a:z", {"gyro_x": "gx:deg/s", "gyro_y": "gy:deg/s", "gyro_z": "gz:deg/s"}),
    ],
)
def test_columns_are_named_by_headers_or_numbers(
    header: str | None, columns: dict[str, str | int], tmp_path: Path
) -> None:
    path = write(tmp_path / "log.csv", header, [SINCE_S, DEG, ACC])
    force = ("a:x", "a:y", "a:z") if header and "a:x" in header else (5, 6, 7)
    axes_of_force = {f"accelerometer_{axis}": name for axis, name in zip("xyz", force, strict=True)}
    require_readings(read_log(path, columns={**columns, **axes_of_force}))


def test_a_sensor_that_is_named_comes_before_one_that_is_found(tmp_path: Path) -> None:
    path = write(tmp_path / "log.csv", f"{HEADER},one,two,three", [SINCE_S, 0 * GYRO, ACC, GYRO])
    assert (read_log(path).gyro.values == 0.0).all()
    require_readings(read_log(path, columns={"gyro_x": "one", "gyro_y": "two", "gyro_z": "three"}))


def test_of_several_sensors_the_first_is_taken_and_the_others_are_told(tmp_path: Path) -> None:
    path = write(tmp_path / "log.csv", f"{HEADER},gyro2_x,gyro2_y,gyro2_z", [SINCE_S, GYRO, ACC, 0 * GYRO])
    log = read_log(path)
    require_readings(log)
    assert "not gyro2_x, gyro2_y, gyro2_z" in " ".join(log.taken)


def test_stamps_are_read_to_the_nanosecond_and_faults_of_theirs_stay(tmp_path: Path) -> None:
    stamps = T.copy()
    stamps[10:20] = 0
    stamps[30] = stamps[29]
    log = read_log(write(tmp_path / "log.csv", "t_ns,gx,gy,gz", [stamps, GYRO]))
    assert log.gyro.t_ns.tolist() == stamps.tolist()
    seconds = [f"{t // 10**9}.{t % 10**9:09d}" for t in T.tolist()]
    assert read_log(write(tmp_path / "log.csv", "time,gx,gy,gz", [seconds, GYRO])).gyro.t_ns.tolist() == T.tolist()


def test_times_in_bursts_have_the_unit_of_their_mean_step(tmp_path: Path) -> None:
    us = np.arange(len(T))
    log = read_log(write(tmp_path / "log.csv", "t,gx,gy,gz", [us // 10 * 200_000 + us % 10 * 10, GYRO]))
    assert "in µs by its steps" in " ".join(log.taken)


def test_imu_topics_are_chosen_by_name_and_declared_variances_are_kept(tmp_path: Path) -> None:
    log = read_log(own_bag(tmp_path), imu="/imu/data_raw", magnetometer="/imu/mag")
    assert log.gyro.arrival_ns is not None
    assert log.gyro.variance is not None
    assert (log.gyro.variance > 0.0).all()


def gap_between_sensors(path: Path) -> Path:
    folder = vmu931(path)
    file = folder / "gyroscopes.csv"
    late = [["gyroscope"] * len(T), (T - T[0]) // 10**6 + 900_000, DEG]
    return write(file, "Attribute,Time stamp,x,y,z", late).parent


def damaged_zip(path: Path) -> Path:
    file = zipped(sensor_logger(path))
    content = bytearray(file.read_bytes())
    content[100:130] = bytes(30)
    file.write_bytes(content)
    return file


def long_zip(path: Path) -> Path:
    with zipfile.ZipFile(path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Gyroscope.csv", "t,x,y,z\n" + "0" * (3 * 2**20))
    return path / "bomb.zip"


def bag_of_text(path: Path) -> Path:
    folder = sqlite(path)
    (folder / "rosbag2_0.db3").write_bytes(b"SQLite format 3\0" + bytes(5000))
    return folder


def bag_without_imu(path: Path) -> Path:
    simulate("tumbling_cubesat", duration=0.1).to_bag(path / "no.mcap")
    return path / "no.mcap"


def bag_of_two(path: Path) -> Path:
    folder = sqlite(path)
    with sqlite3.connect(folder / "rosbag2_0.db3") as bag:
        bag.execute("INSERT INTO topics VALUES (99, '/other', 'sensor_msgs/msg/Imu', 'cdr', '')")
        bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (99, 0, x'00')")
    bag.close()
    return folder


BAD: list[tuple[Make, dict[str, object], str]] = [
    (lambda path: path / "none.csv", {}, "none.csv"),
    (text(""), {}, "no row"),
    (text(HEADER), {}, "no row"),
    (text("hello", "world"), {}, "hello"),
    (lambda path: write_text(path / "log.csv", b"\x89PNG\r\n\x1a\n\0\0"), {}, "no text"),
    *(
        (text(HEADER, *LINES[:3], LINES[3].replace(LINES[3].split(",")[2], cell), *LINES[4:]), {}, "line 5")
        for cell in ("NaN", "inf", "x", "1_0", "")
    ),
    (text(HEADER, *LINES[:3], "later" + LINES[3][3:], *LINES[4:]), {}, "line 5"),
    (text(HEADER, *LINES[:3], "," + LINES[3].partition(",")[2], *LINES[4:]), {}, "line 5"),
    (text(HEADER, *LINES[:3], "1e99999999999" + LINES[3][3:], *LINES[4:]), {}, "line 5"),
    (text(HEADER, *LINES[:3], LINES[3][:20]), {}, "line 5"),
    (text(HEADER, *LINES[:3], f"{LINES[3]},1"), {}, "line 5"),
    (text(HEADER, *LINES[:3], '"' + LINES[3] + "9" * 200_000), {}, "line 5"),
    (text("t,ax,ay,az", *[",".join(line.split(",")[:4]) for line in LINES]), {}, "no gyro"),
    (text("n,gx,gy,gz", *[",".join(line.split(",")[:4]) for line in LINES]), {}, "no time"),
    (text("t,gx,gy,gz", *["5,0,0,0"] * 9), {}, "no time"),
    (text(*LINES), {}, "such as t=1"),
    (text(HEADER, *LINES), {"columns": {"gyro_q": "gx"}}, "gyro_x"),
    (text(HEADER, *LINES), {"columns": {"gyro_x": "hx"}}, "hx"),
    (text(HEADER, *LINES), {"columns": {"gyro_x": 99}}, "99"),
    (text(HEADER, *LINES), {"columns": ["gx"]}, "wx:deg/s"),
    (text(HEADER, *[f"2024-13-45 10:11:12{line[line.index(',') :]}" for line in LINES]), {}, "line 2: Month"),
    (text('"' + "9" * 200_000 + ",gx,gy,gz", *LINES), {}, "such as t=1"),
    (text(HEADER, *LINES), {"columns": {"gyro_x": "ax"}}, "three axes"),
    (text(HEADER, *LINES), {"columns": {"gyro_x": "gx:kg", "gyro_y": "gy:kg", "gyro_z": "gz:kg"}}, "kg"),
    (text(HEADER, *LINES), {"columns": {"gyro_x": "gx:deg/s", "gyro_y": "gy", "gyro_z": "gz"}}, "all three axes"),
    (phyphox, {"columns": {"gyro_x": 2, "gyro_y": 3, "gyro_z": 4}}, "no column 2"),
    (text(HEADER, *LINES), {"imu": "/imu"}, "columns"),
    (lambda path: write_text(path / "old.bag", b"#ROSBAG V2.0\n"), {}, "rosbags-convert"),
    (gap_between_sensors, {}, "overlap"),
    (damaged_zip, {}, "cannot be read"),
    (lambda path: write_text(path / "z.zip", b"PK\3\4" + bytes(40)), {}, "cannot be read"),
    (long_zip, {}, "no gyro"),
    (lambda path: path, {}, "no CSV"),
    (bag_of_text, {}, "SQLite"),
    (bag_without_imu, {}, "/pose"),
    (bag_of_two, {}, "/other"),
    (bag_of_two, {"imu": "/other"}, "message 0"),
    (own_bag, {"imu": "/imu"}, "/imu/data_raw"),
    (own_bag, {"columns": {"gyro_x": "gx"}}, "topics"),
]


@pytest.mark.parametrize(("make", "how", "told"), BAD)
def test_files_that_are_no_logs_are_refused_in_one_line(make: Make, how: dict, told: str, tmp_path: Path) -> None:
    path = make(tmp_path)
    with pytest.raises(LieRigidBodyError) as error:
        read_log(path, **how)
    said = str(error.value)
    assert told in said
    assert "\n" not in said
    assert len(said) < 500
