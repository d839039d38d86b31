"""Writes a recording as RealSense programs did until they wrote `.db3`: a bag of ROS 1.

Sources: the ROS wiki's "Bags/Format/2.0", and the message definitions of std_msgs, sensor_msgs,
geometry_msgs, diagnostic_msgs and the SDK's realsense_msgs.
"""

import struct

_SIZE = 64, 48
_TYPES = {
    "std_msgs/UInt32": "304a39449588c7f8ce2df6e8001c5fce",
    "std_msgs/Float32": "73fcbf46b49191e672908e50842a83d4",
    "std_msgs/String": "992ce8a1687cec8c8bd883ec73ca41d1",
    "diagnostic_msgs/KeyValue": "cf57fdc6617a881a88c16e768132149c",
    "realsense_msgs/StreamInfo": "311d7e24eac31bb87271d041bf70ff7d",
    "realsense_msgs/ImuIntrinsic": "aebdc2f8f9726f1c3ca823ab56e47429",
    "sensor_msgs/CameraInfo": "c9a58c1b0b154e0e6da7578cb991d214",
    "sensor_msgs/Image": "060021388200f6f0f447d0fcd9c64743",
    "sensor_msgs/Imu": "6a62c6daae103f4ff57a132d6f95cec2",
    "geometry_msgs/Transform": "ac9eff44abf714214112b05d54a3cf9b",
}
"""Checksums of the definitions of messages."""
_STATIC = 1
"""Time of what holds for the whole recording [ns]."""


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def pair(key, value):
    return text(key) + text(value)


def stamp_of(nanoseconds):
    return struct.pack("<II", *divmod(nanoseconds, 10**9))


def message_header(nanoseconds):
    return struct.pack("<I", 0) + stamp_of(nanoseconds) + text("0")


def camera_info():
    width, height = _SIZE
    matrix = (61.0, 0.0, 32.0, 0.0, 61.0, 24.0, 0.0, 0.0, 1.0)
    return (
        message_header(0)
        + struct.pack("<II", height, width)
        + text("Brown Conrady")
        + struct.pack("<I5d", 5, *(0.0,) * 5)
        + struct.pack("<9d", *matrix)
        + struct.pack("<9d12d", *(0.0,) * 21)
        + bytes(25)
    )


def image(nanoseconds, encoding, pixels):
    height, width = pixels.shape[:2]
    content = pixels.tobytes()
    return (
        message_header(nanoseconds)
        + struct.pack("<II", height, width)
        + text(encoding)
        + struct.pack("<BII", 0, len(content) // height, len(content))
        + content
    )


def imu(nanoseconds, rate=(0.0,) * 3, force=(0.0,) * 3):
    values = (*(0.0,) * 13, *rate, *(0.0,) * 9, *force, *(0.0,) * 9)
    return message_header(nanoseconds) + struct.pack("<37d", *values)


def descriptions():
    """(topic, type, message) of what holds for the whole recording."""
    yield "/file_version", "std_msgs/UInt32", struct.pack("<I", 3)
    device = {
        "Name": "Intel RealSense D435I", "Serial Number": "900000000001",
        "Firmware Version": "5.16.0.1", "Product Line": "D400", "Product Id": "0B3A",
        "Physical Port": "bag", "Usb Type Descriptor": "3.2",
    }  # fmt: skip
    for key, value in device.items():
        yield "/device_0/info", "diagnostic_msgs/KeyValue", pair(key, value)
    for number, name in enumerate(("Stereo Module", "RGB Camera", "Motion Module")):
        topic = f"/device_0/sensor_{number}/info"
        yield topic, "diagnostic_msgs/KeyValue", pair("Name", name)
    option = "/device_0/sensor_0/option/Depth_Units"
    yield f"{option}/value", "std_msgs/Float32", struct.pack("<f", 0.001)
    yield f"{option}/description", "std_msgs/String", text("metres in a unit of depth")
    streams = {
        "/device_0/sensor_0/Depth_0": (30, "mono16"),
        "/device_0/sensor_1/Color_0": (30, "rgb8"),
        "/device_0/sensor_2/Gyro_0": (200, "MOTION_XYZ32F"),
        "/device_0/sensor_2/Accel_0": (100, "MOTION_XYZ32F"),
    }
    for stream, (rate, encoding) in streams.items():
        description = struct.pack("<I", rate) + text(encoding) + b"\1"
        yield f"{stream}/info", "realsense_msgs/StreamInfo", description
        if "Depth" in stream or "Color" in stream:
            yield f"{stream}/info/camera_info", "sensor_msgs/CameraInfo", camera_info()
        else:
            intrinsic = struct.pack("<18f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(0,) * 6)
            yield f"{stream}/imu_intrinsic", "realsense_msgs/ImuIntrinsic", intrinsic
        yield f"{stream}/tf/0", "geometry_msgs/Transform", struct.pack("<7d", *(0,) * 6, 1)


def measurements(frames):
    """(time, topic, type, message) of images and samples.

    Args:
        frames: (stamp [s], RGB (H, W, 3) uint8, depth (H, W) uint16 [mm]) of each.
    """
    for number, (stamp, rgb, depth) in enumerate(frames):
        taken = round(1e9 * stamp)
        for stream, before, message in (
            ("Gyro_0", 5_000_000, imu(taken - 5_000_000, rate=(0.1, 0.2, 0.3))),
            ("Accel_0", 4_000_000, imu(taken - 4_000_000, force=(0.0, 0.0, 9.8))),
        ):
            topic = f"/device_0/sensor_2/{stream}/imu"
            due = taken - before - round(1e9 * frames[0][0]) + 10**8
            yield due, f"{topic}/data", "sensor_msgs/Imu", message
            yield from metadata(due, topic, number)
        for topic, encoding, pixels in (
            ("/device_0/sensor_0/Depth_0/image", "mono16", depth),
            ("/device_0/sensor_1/Color_0/image", "rgb8", rgb),
        ):
            due = taken - round(1e9 * frames[0][0]) + 10**8
            yield due, f"{topic}/data", "sensor_msgs/Image", image(taken, encoding, pixels)
            yield from metadata(due, topic, number)


def metadata(due, topic, number):
    for key, value in (("Frame number", str(number)), ("timestamp_domain", "Global Time"),
                       ("system_time", "0")):  # fmt: skip
        yield due, f"{topic}/metadata", "diagnostic_msgs/KeyValue", pair(key, value)


def record(data, **fields):
    """A record of a bag: fields by name, and data."""
    header = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value
        for name, value in fields.items()
    )
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def number(value, kind="<I"):
    return struct.pack(kind, value)


def write_recording(path, frames):
    """Write a bag of RGB, depth and IMU, in one chunk without compression."""
    messages = [(_STATIC, *each) for each in descriptions()] + list(measurements(frames))
    connections, chunk, places = {}, b"", {}
    for due, topic, kind, message in messages:
        if topic not in connections:
            connections[topic] = connection(len(connections), topic, kind)
            chunk += connections[topic]
        identity = list(connections).index(topic)
        places.setdefault(identity, []).append((due, len(chunk)))
        chunk += record(message, op=b"\2", conn=number(identity), time=stamp_of(due))
    magic = b"#ROSBAG V2.0\n"
    chunk_place = len(magic) + 4096
    body = record(chunk, op=b"\5", compression=b"none", size=number(len(chunk)))
    for identity, entries in places.items():
        index = b"".join(stamp_of(due) + number(place) for due, place in entries)
        count = number(len(entries))
        body += record(index, op=b"\4", ver=number(1), conn=number(identity), count=count)
    index_place = chunk_place + len(body)
    body += b"".join(connections.values())
    times = [due for due, *_ in messages]
    counts = b"".join(number(key) + number(len(entries)) for key, entries in places.items())
    body += record(
        counts, op=b"\6", ver=number(1), chunk_pos=number(chunk_place, "<Q"),
        start_time=stamp_of(min(times)), end_time=stamp_of(max(times)), count=number(len(places)),
    )  # fmt: skip
    fields = {"op": b"\3", "index_pos": number(index_place, "<Q"),
              "conn_count": number(len(connections)), "chunk_count": number(1)}  # fmt: skip
    padding = b" " * (4096 - len(record(b"", **fields)))
    path.write_bytes(magic + record(padding, **fields) + body)


def connection(identity, topic, kind):
    fields = (f"topic={topic}", f"type={kind}", f"md5sum={_TYPES[kind]}", "message_definition=")
    description = b"".join(text(field) for field in fields)
    return record(description, op=b"\7", conn=number(identity), topic=topic.encode())
