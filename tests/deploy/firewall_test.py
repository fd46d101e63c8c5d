#!/usr/bin/env python3
"""Loads deploy/cairn.nft in a network namespace of its own and sends datagrams to a plane's port: only LCM's short
messages from the run's hosts may arrive. Usage: firewall_test.py ROOT; exit status 77 when the machine has no nft or
allows no namespace."""

import pathlib
import shutil
import socket
import struct
import subprocess
import sys

GROUP, PORT = "239.255.76.67", 7700
HOST, FOREIGNER = "10.0.0.1", "10.0.0.9"
SKIPPED = 77

SHORT = b"LC02" + bytes(4) + b"CAIRN_STATUS\0message"
DATAGRAMS = [  # (source, payload, whether it may arrive)
    (HOST, SHORT, True),
    (FOREIGNER, SHORT, False),
    (HOST, b"LC03" + struct.pack(">IIIHH", 0, 100, 0, 0, 1) + b"CAIRN_STATUS\0", False),
    (HOST, b"LC03", False),
    (HOST, b"LC04" + bytes(100), False),
    (HOST, b"LC02" + bytes(1390), True),
    (HOST, b"LC02" + bytes(3), False),
    (HOST, b"", False),
    (FOREIGNER, b"LC03" + bytes(100), False),
    (HOST, SHORT, True),
]


def run(*command):
    subprocess.run(command, check=True)


def set_up(root):
    run("ip", "link", "set", "lo", "up")
    run("ip", "route", "add", "224.0.0.0/4", "dev", "lo")
    for address in (HOST, FOREIGNER):
        run("ip", "address", "add", address + "/32", "dev", "lo")
    run("nft", "-f", str(root / "deploy/cairn.nft"))
    run("nft", "-f", str(root / "deploy/cairn.nft"))  # loading it again replaces it


def receiver():
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    s.bind((GROUP, PORT))
    s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton("127.0.0.1"))
    s.settimeout(5)
    return s


def send(source, payload):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind((source, 0))
        s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        s.sendto(payload, (GROUP, PORT))


def test(root):
    set_up(root)
    listening = receiver()
    for source, payload, _ in DATAGRAMS:
        send(source, payload)
    expected = [(source, payload) for source, payload, passes in DATAGRAMS if passes]
    # The last one passes and loopback keeps the order, so nothing is still to come.
    arrived = []
    while len(arrived) < len(expected):
        payload, (source, _) = listening.recvfrom(65536)
        arrived.append((source, payload))
    if arrived != expected:
        sys.exit(f"arrived: {arrived}\nexpected: {expected}")
    print("ok")


def enter(root):
    if not shutil.which("nft") or not shutil.which("ip"):
        return SKIPPED
    for namespaces in (["unshare", "-n"], ["unshare", "-rn"]):
        if subprocess.run([*namespaces, "true"], stderr=subprocess.DEVNULL).returncode == 0:
            return subprocess.run([*namespaces, sys.executable, __file__, root, "inside"]).returncode
    return SKIPPED


if __name__ == "__main__":
    if len(sys.argv) == 2:
        sys.exit(enter(sys.argv[1]))
    test(pathlib.Path(sys.argv[1]))
