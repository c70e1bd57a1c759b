"""Writes the seeds that are made of fixtures/formats and by hand: `python fuzz/seeds/write.py`.

A fuzzer gets nowhere with a file of 40 kB whose samples it changes: these are a few records each, and
where a checksum would keep it out there is one without."""

import io
import struct
import zipfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parent.parent / "fixtures/formats"
ROWS = 12
# of logs with many frames only so many-th ones, so that a few last longer than the least of a ride, 1 s
EVERY = 7


def put(target, name, data):
    folder = HERE / target
    folder.mkdir(exist_ok=True)
    (folder / name).write_bytes(data)


# --- MDF 4: the sample of a logger, its streams cut --------------------------------------------------------

def blocks(data):
    """Every block by its place: id, links, data."""
    found, todo = {}, [64]
    while todo:
        at = todo.pop()
        if at == 0 or at in found:
            continue
        length, count = struct.unpack_from("<QQ", data, at + 8)
        links = list(struct.unpack_from(f"<{count}Q", data, at + 24))
        found[at] = [data[at:at + 4], links, bytearray(data[at + 24 + 8 * count:at + length])]
        todo += links
    return found


def assemble(head, found):
    order = sorted(found, key=lambda at: (at != 64, at))
    places, at = {}, 64
    for old in order:
        places[old] = at
        at += (24 + 8 * len(found[old][1]) + len(found[old][2]) + 7) // 8 * 8
    out = bytearray(head)
    for old in order:
        name, links, body = found[old]
        out += struct.pack("<4s4xQQ", name, 24 + 8 * len(links) + len(body), len(links))
        out += struct.pack(f"<{len(links)}Q", *[places.get(link, 0) for link in links]) + body
        out += bytes(-len(out) % 8)
    return bytes(out)


def transposed(data, columns):
    lines = len(data) // columns
    rest = data[lines * columns:]
    return bytes(data[line * columns + c] for c in range(columns) for line in range(lines)) + rest


def mdf4(name, packed):
    whole = (SAMPLES / name).read_bytes()
    found = blocks(whole)
    dg = found[64][1][0]
    while dg:
        _, cg, data, _ = found[dg][1]
        size = sum(struct.unpack_from("<II", found[cg][2], 24)) + found[dg][2][0]
        struct.pack_into("<Q", found[cg][2], 8, ROWS)
        stream = found[data][2][:ROWS * size]
        if packed:
            rows = zlib.compress(transposed(stream, size))
            head = struct.pack("<2sBBIQQ", b"DT", 1, 0, size, len(stream), len(rows))
            found[data] = [b"##DZ", [], bytearray(head + rows)]
            # a list with two blocks, the second plain
            one, two, all_of = data, -dg, -dg - 1
            found[two] = [b"##DT", [], bytearray(stream)]
            found[all_of] = [b"##DL", [0, one, two], bytearray(struct.pack("<B3xIQQ", 0, 2, 0, len(stream)))]
            struct.pack_into("<Q", found[cg][2], 8, 2 * ROWS)
            found[dg][1][2] = all_of
        else:
            found[data][2] = stream
        dg = found[dg][1][0]
    # the history and what it says of the writer
    found[64][1][1:2] = [0]
    reached, todo = set(), [64]
    while todo:
        at = todo.pop()
        if at in found and at not in reached:
            reached.add(at)
            todo += found[at][1]
    return assemble(whole[:64], {at: found[at] for at in reached})


def unfinalised():
    whole = (SAMPLES / "ride_unfinalised.mf4").read_bytes()
    stream = whole.rindex(b"##DT\0\0\0\0")
    return whole[:stream + 24 + 300]


# --- MDF 3, by hand -----------------------------------------------------------------------------------------

def mdf3():
    names = [("time", "s", 1, 64, 3), ("velocity_x", "km/h", 0, 32, 2), ("gear", "", 0, 8, 0), ("roll", "deg", 0, 16, 1)]
    head = b"MDF     3.30    asammdf \0" + bytes(39)
    head = bytearray(head)
    struct.pack_into("<HHHH", head, 24, 0, 0, 330, 0)
    dg, cg = 64 + 208, 64 + 208 + 28
    first = cg + 30
    each = 228 + 62
    data = first + each * len(names)
    size = sum(bits for *_, bits, _ in names) // 8
    hd = struct.pack("<2sHIIIH10s8s32s32s32s32sQhH32s", b"HD", 208, dg, 0, 0, 1, b"01:05:2026", b"12:02:04",
                     b"rider", b"", b"", b"", 1777636924 * 10**9, 0, 0, b"")
    out = bytes(head) + hd
    out += struct.pack("<2sHIIIIHHI", b"DG", 28, 0, cg, 0, data, 1, 0, 0)
    out += struct.pack("<2sHIIIHHHII", b"CG", 30, 0, first, 0, 0, len(names), size, ROWS, 0)
    start = 0
    for i, (name, unit, kind, bits, dtype) in enumerate(names):
        at = first + i * each
        following = at + each if i + 1 < len(names) else 0
        out += struct.pack("<2sHIIIIIH32s128sHHHHdddIIH", b"CN", 228, following, at + 228, 0, 0, 0, kind, name.encode(),
                           b"", start, bits, dtype, 0, 0, 0, 0.1, 0, 0, 0)
        out += struct.pack("<2sHHdd20sHHdd", b"CC", 62, 0, 0, 0, unit.encode(), 0, 2, 0.0, 1.0)
        start += bits
    for i in range(ROWS):
        out += struct.pack("<dfBh", i * 0.1, 60 + i, 3, -5 * i)
    return out


# --- MCAP: a sample's first chunk, its checksum taken out ---------------------------------------------------

def mcap(name, plain):
    whole = (SAMPLES / name).read_bytes()
    out, at = bytearray(whole[:8]), 8
    while True:
        code, length = struct.unpack_from("<BQ", whole, at)
        record = bytearray(whole[at:at + 9 + length])
        at += 9 + length
        if code == 6:
            if plain:
                record = plain_chunk(record)
            else:
                struct.pack_into("<I", record, 9 + 24, 0)
        out += record
        if code == 6:
            break
    out += struct.pack("<BQI", 0x0F, 4, 0) + struct.pack("<BQQQI", 2, 20, 0, 0, 0)
    return bytes(out + whole[:8])


def plain_chunk(record):
    """The chunk, unpacked (LZ4, whose blocks are packed by themselves), with few of its messages."""
    start, end, size, _, name = struct.unpack_from("<QQQII", record, 9)
    packed = record[9 + 32 + name + 8:]
    records = lz4(bytes(packed))[:size]
    at, count, kept = 0, 0, bytearray()
    while at < len(records):
        code, length = struct.unpack_from("<BQ", records, at)
        if code != 5 or count % EVERY == 0:
            kept += records[at:at + 9 + length]
        at += 9 + length
        count += code == 5
    records, at = bytes(kept), len(kept)
    body = struct.pack("<QQQII", start, end, at, 0, 0) + struct.pack("<Q", at) + records
    return struct.pack("<BQ", 6, len(body)) + body


def lz4(frame):
    flags = frame[4]
    at = 7 + (8 if flags & 8 else 0)
    out = bytearray()
    while (size := struct.unpack_from("<I", frame, at)[0]) != 0:
        at += 4
        plain, size = size >> 31, size & 0x7FFFFFFF
        block = frame[at:at + size]
        at += size + (4 if flags & 16 else 0)
        if plain:
            out += block
            continue
        i = 0
        while i < len(block):
            token = block[i]
            i += 1
            literals, i = run(block, i, token >> 4)
            out += block[i:i + literals]
            i += literals
            if i >= len(block):
                break
            offset = block[i] | block[i + 1] << 8
            copied, i = run(block, i + 2, token & 15)
            for _ in range(copied + 4):
                out.append(out[-offset])
    return bytes(out)


def run(block, i, n):
    if n == 15:
        while True:
            n += block[i]
            i += 1
            if block[i - 1] != 255:
                break
    return n, i


# --- CAN ----------------------------------------------------------------------------------------------------

def blf(packed):
    whole = (SAMPLES / "ride.blf").read_bytes()
    head = struct.unpack_from("<I", whole, 4)[0]
    size = struct.unpack_from("<I", whole, head + 8)[0]
    unpacked = zlib.decompress(whole[head + 32:head + size])
    at, frames = 0, []
    while at + 16 < len(unpacked):
        size = struct.unpack_from("<I", unpacked, at + 8)[0]
        frames.append(unpacked[at:at + size + size % 4])
        at += size + size % 4
    frames = b"".join(frames[:-1:EVERY])
    body = zlib.compress(frames) if packed else frames
    container = struct.pack("<4sHHII", b"LOBJ", 16, 1, 32 + len(body), 10)
    container += struct.pack("<H6xI4x", 2 if packed else 0, len(frames)) + body
    return whole[:head] + container + bytes(len(container) % 4)


def lines(name, head):
    whole = (SAMPLES / name).read_bytes().splitlines(keepends=True)
    return b"".join(whole[:head] + whole[head::EVERY][:3 * ROWS])


# --- loggers of motorcycles ---------------------------------------------------------------------------------

def gpx():
    """What follows the first element, which the target brings; a dozen points."""
    whole = (SAMPLES / "circle_garmin.gpx").read_bytes()
    points = whole[whole.index(b"<trk>"):].split(b"</trkpt>")
    return b"</trkpt>".join(points[:ROWS]) + b"</trkpt></trkseg></trk></gpx>"


def motec_ld():
    names = [(b"GPS Speed", b"km/h", 3, 2), (b"Lean Angle", b"deg", 5, 4), (b"Wheel Speed Front", b"km/h", 7, 4),
             (b"Gear", b"", 7, 2)]
    out = bytearray(0x664)
    first = len(out)
    struct.pack_into("<III", out, 0, 64, 0, first)
    for at, text in ((0x5e, b"01/05/2026"), (0x7e, b"10:00:00"), (0x9e, b"A. Rider"), (0xde, b"R1"), (0x15e, b"Calder")):
        out[at:at + len(text)] = text
    data = first + 84 * len(names)
    samples = b""
    for i, (name, unit, kind, width) in enumerate(names):
        following = first + 84 * (i + 1) if i + 1 < len(names) else 0
        out += struct.pack("<IIIIHHHHhhhh32s8s12s", max(first + 84 * (i - 1), 0), following, data + len(samples), ROWS, 0,
                           kind, width, 10, 0, 1, 1, 1, name, b"", unit)
        code = {(3, 2): "h", (5, 4): "i", (7, 4): "f", (7, 2): "e"}[kind, width]
        samples += struct.pack(f"<{ROWS}{code}", *[300 + k for k in range(ROWS)])
    return bytes(out) + samples


def ctrk():
    """What follows the header's first 52 bytes, which the target brings."""
    out = struct.pack("<IB", 0x1F, 0x11) + b"RECORDLINE.P1.LAT(\xa1\xf2\xaf\xe5\x95\xf9\x47\x40"

    def record(kind, ms, payload):
        time = struct.pack("<HBBBBBBH", ms % 1000, 34 + ms // 1000, 21, 12, 2, 29, 7, 2025)
        return struct.pack("<HH", kind, 14 + len(payload)) + time + payload

    for i in range(ROWS):
        for identifier in (0x0209, 0x0215, 0x023E, 0x0250, 0x0258, 0x0260, 0x0264, 0x0268):
            data = bytes((40 + 3 * i + k) & 0xFF for k in range(8))
            out += record(1, 100 * i, struct.pack("<HHB", identifier, 0, 8) + data)
        sentence = b"GPRMC,122134.%d00,A,4757.0410,N,00012.5240,E,25.3,334.60,290725,,,A" % (i % 10)
        check = 0
        for byte in sentence:
            check ^= byte
        out += record(2, 100 * i, b"$%s*%02X\r\n\0" % (sentence, check))
    return out + b'{"Attribute": [{"Key": "CircuitName", "Value": "Calder"}, {"Key": "User", "Value": "R122"}]}'


def kiro():
    """Two seconds; the target brings the first lines."""
    text = ""
    for ms in range(300, 2400, 100):
        text += f"susp {500 + ms // 100},{480 - ms // 100},{ms}\n15,{3000 + ms},0,0,0,{ms}\n"
        if ms % 500 == 0:
            text += f"$GPGGA,12000{ms // 1000}.{ms % 1000:03},4044.{ms:04},N,00150.2000,W,$GPVTG,12.5,T,,M,21.60,N,40.00,K,{ms}\n"
    return text.encode()


def racing_text():
    """The byte that says whose, then what follows the line that the target brings."""
    for who, name in enumerate(("motec_i2.csv", "aim_rs3.csv", "racechrono_v3.csv", "xsens_mti.txt", "racebox.csv")):
        whole = (SAMPLES / "racing" / name).read_bytes().splitlines(keepends=True)
        if name.startswith("xsens"):
            header = next(i for i, line in enumerate(whole) if line.startswith(b"PacketCounter\t"))
            whole[header] = whole[header].removeprefix(b"PacketCounter\t")
            rest = [whole[header], *whole[header + 1::10][:ROWS]]
        elif name.startswith("racebox"):
            rest = whole[1:45]
        elif name.startswith("race"):
            rest = whole[1:12] + whole[12::10][:ROWS]
        else:
            rest = whole[1:45]
        put("racing_text", name, bytes([who]) + b"".join(rest))


def devices():
    """The first byte says which: `devices.rs`."""
    for which, name, most in ((0, "circle.fit", 700), (1, "circle.nmea", 1800), (2, "circle.ubx", 1800)):
        put("devices", name, bytes([which]) + (SAMPLES / name).read_bytes()[:most])
    text = io.BytesIO()
    with zipfile.ZipFile(text, "w", zipfile.ZIP_DEFLATED) as archive:
        rows = "".join(f"{1782900000 + i}000000000,{i},{20 + i},{8 + 1e-4 * i},{47 + 1e-4 * i}\n" for i in range(ROWS))
        where = zipfile.ZipInfo("Location.csv", (2026, 7, 1, 10, 2, 0))
        archive.writestr(where, "time,seconds_elapsed,speed,longitude,latitude\n" + rows, zipfile.ZIP_DEFLATED)
    put("devices", "phone.zip", b"\3" + text.getvalue())


def main():
    devices()
    put("mdf", "plain.mf4", mdf4("ride_logger.mf4", False))
    put("mdf", "packed.mf4", mdf4("ride_logger.mf4", True))
    put("mdf", "unfinalised.mf4", unfinalised())
    put("mdf", "three.mdf", mdf3())
    put("mcap", "json.mcap", mcap("ride_json_lz4.mcap", True))
    put("mcap", "ros2.mcap", mcap("ride_ros2.mcap", False))
    put("can", "packed.blf", blf(True))
    put("can", "plain.blf", blf(False))
    put("can", "ride.asc", lines("ride.asc", 5))
    put("can", "ride.log", lines("ride_candump.log", 0))
    put("can", "ride.trc", lines("ride.trc", 16))
    put("gpx", "circle.gpx", gpx())
    put("dbc", "ride.dbc", (SAMPLES / "ride.dbc").read_bytes())
    put("motec_ld", "ride.ld", motec_ld())
    put("ctrk", "ride", ctrk())
    put("kiro", "ride.txt", kiro())
    racing_text()


main()
