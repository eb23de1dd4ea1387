r"""A broker for LCM's tcpq transport, for the tests: messages of a channel go to all who subscribed to it.

It listens on 127.0.0.1 alone. liblcm writes a message in five pieces without TCP_NODELAY, and waits for the acknowledgement of the first:
TCP_QUICKACK on our side makes that immediate, or each message takes 40 ms. A subscription is a
regular expression that the whole channel's name matches: Drake subscribes to IIWA\_COMMAND.

Usage: broker.py PORT    (0: a free one; the port is printed)
"""
import re
import selectors
import socket
import struct
import sys

HELLO_CLIENT, HELLO_SERVER, VERSION = 0x287617FB, 0x287617FA, 0x0100
PUBLISH, SUBSCRIBE, UNSUBSCRIBE = 1, 2, 3
MOST = 1 << 20  # bytes of a message


class Client:
    def __init__(self, connection):
        self.connection = connection
        self.received = bytearray()
        self.greeted = False
        self.channels = {}  # subscription: compiled
        self.wants = {}  # channel: whether a subscription matches it

    def wanted(self, channel):
        if channel not in self.wants:
            self.wants[channel] = any(pattern.fullmatch(channel) for pattern in self.channels.values())
        return self.wants[channel]

    def messages(self):
        """Takes complete messages from what was received: (kind, channel, payload). Raises ValueError for what is no tcpq."""
        data = self.received
        if not self.greeted:
            if len(data) < 8:
                return
            if struct.unpack_from(">II", data) != (HELLO_CLIENT, VERSION):
                raise ValueError("no tcpq client")
            del data[:8]
            self.greeted = True
            self.connection.sendall(struct.pack(">II", HELLO_SERVER, VERSION))
        while len(data) >= 8:
            kind, size = struct.unpack_from(">II", data)
            if kind not in (PUBLISH, SUBSCRIBE, UNSUBSCRIBE) or size > 63:
                raise ValueError("no tcpq message")
            end = 8 + size
            payload = b""
            if kind == PUBLISH:
                if len(data) < end + 4:
                    return
                (length,) = struct.unpack_from(">I", data, end)
                if length > MOST:
                    raise ValueError("message too long")
                if len(data) < end + 4 + length:
                    return
                payload = bytes(data[end + 4 : end + 4 + length])
                channel = bytes(data[8:end])
                end += 4 + length
            else:
                if len(data) < end:
                    return
                channel = bytes(data[8:end])
            del data[:end]
            yield kind, channel, payload


def serve(port, ready):
    selector = selectors.DefaultSelector()
    server = socket.create_server(("127.0.0.1", port))
    selector.register(server, selectors.EVENT_READ)
    ready(server.getsockname()[1])
    clients = set()

    def drop(client):
        selector.unregister(client.connection)
        client.connection.close()
        clients.discard(client)

    while True:
        for key, _ in selector.select():
            if key.fileobj is server:
                connection, _ = server.accept()
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
                connection.settimeout(2.0)  # of a send: a client that reads nothing is dropped
                client = Client(connection)
                clients.add(client)
                selector.register(connection, selectors.EVENT_READ, client)
                continue
            client = key.data
            if client not in clients:
                continue
            try:
                data = client.connection.recv(65536)
                client.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)  # does not last
                if not data:
                    drop(client)
                    continue
                client.received += data
                for kind, channel, payload in client.messages():
                    if kind == SUBSCRIBE:
                        client.channels[channel] = re.compile(channel)
                        client.wants.clear()
                    elif kind == UNSUBSCRIBE:
                        client.channels.pop(channel, None)
                        client.wants.clear()
                    else:
                        packet = struct.pack(">II", PUBLISH, len(channel)) + channel + struct.pack(">I", len(payload)) + payload
                        for other in list(clients):
                            if other.wanted(channel):
                                try:
                                    other.connection.sendall(packet)
                                except OSError:
                                    drop(other)
            except (OSError, ValueError, re.error):
                if client in clients:
                    drop(client)


if __name__ == "__main__":
    try:
        serve(int(sys.argv[1]), lambda port: print(port, flush=True))
    except KeyboardInterrupt:
        pass
