"""The server of another project with one DINT: servers.py cm_ethernetip|cpppo TAG. Prints `ready eip=HOST:PORT`, then serves."""

import asyncio
import socket
import sys
import threading
import time

which, tag = sys.argv[1:3]


def ready(port):
    print(f"ready eip=127.0.0.1:{port}", flush=True)


if which == "cm_ethernetip":
    from ethernetip.cip.identity_info import IdentityInfo
    from ethernetip.logix.logix_dispatcher import LogixDispatcher
    from ethernetip.protocol.eip_adapter import EipAdapter

    async def serve():
        identity = IdentityInfo(vendor_id=1, device_type=14, product_code=1, product_name="Other")
        dispatcher = LogixDispatcher(identity=identity)
        dispatcher.tags.add_tag(tag, 0xC4)
        adapter = EipAdapter(dispatcher, identity)
        await adapter.listen("127.0.0.1", 0)
        ready(adapter.port)
        await asyncio.Event().wait()

    asyncio.run(serve())
else:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]

    def announce():
        while True:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    return ready(port)
            time.sleep(0.05)

    threading.Thread(target=announce, daemon=True).start()
    from cpppo.server.enip.main import main

    sys.exit(main(argv=["--address", f"127.0.0.1:{port}", f"{tag}=DINT"]))
