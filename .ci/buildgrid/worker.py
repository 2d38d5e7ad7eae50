"""A worker for BuildGrid: takes leases over the Remote Workers API and runs them, one at a time.

BuildGrid has a scheduler but no worker, and there is no package of buildbox-worker. This worker is
slow and obvious, and runs commands without a sandbox: it is for tests only. Its messages are BuildGrid's.

    worker.py ADDRESS NAME FOLDER
"""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import uuid

import grpc
from buildgrid._protos.build.bazel.remote.execution.v2 import remote_execution_pb2 as api
from buildgrid._protos.build.bazel.remote.execution.v2 import remote_execution_pb2_grpc as services
from buildgrid._protos.google.bytestream import bytestream_pb2, bytestream_pb2_grpc
from buildgrid._protos.google.devtools.remoteworkers.v1test2 import bots_pb2, bots_pb2_grpc, worker_pb2

LARGE = 1 << 20  # Blobs of more bytes are streamed.
BATCH = 3 << 20  # Bytes of blobs in one request.


class Store:
    """The content-addressed store, with a copy of everything that was read."""

    def __init__(self, channel, folder):
        self.store = services.ContentAddressableStorageStub(channel)
        self.stream = bytestream_pb2_grpc.ByteStreamStub(channel)
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def path(self, digest):
        return self.folder / digest.hash

    def fetch(self, digests):
        missing = {d.hash: d for d in digests if d.size_bytes and not self.path(d).exists()}
        request, size = api.BatchReadBlobsRequest(), 0
        for digest in missing.values():
            if digest.size_bytes > LARGE:
                name = "blobs/%s/%d" % (digest.hash, digest.size_bytes)
                parts = self.stream.Read(bytestream_pb2.ReadRequest(resource_name=name))
                self.keep(digest, b"".join(part.data for part in parts))
                continue
            if size + digest.size_bytes > BATCH:
                self.fetch_batch(request)
                request, size = api.BatchReadBlobsRequest(), 0
            request.digests.append(digest)
            size += digest.size_bytes
        self.fetch_batch(request)

    def fetch_batch(self, request):
        if request.digests:
            for response in self.store.BatchReadBlobs(request).responses:
                assert response.status.code == 0, response.status.message
                self.keep(response.digest, response.data)

    def keep(self, digest, data):
        assert hashlib.sha256(data).hexdigest() == digest.hash
        self.path(digest).write_bytes(data)

    def read(self, digest):
        self.fetch([digest])
        return self.path(digest).read_bytes() if digest.size_bytes else b""

    def upload(self, blobs):
        request, size = api.BatchUpdateBlobsRequest(), 0
        for digest, data in blobs:
            if len(data) > LARGE:
                self.stream.Write(iter(self.parts(digest, data)))
                continue
            if size + len(data) > BATCH:
                self.upload_batch(request)
                request, size = api.BatchUpdateBlobsRequest(), 0
            request.requests.add(digest=digest, data=data)
            size += len(data)
        self.upload_batch(request)

    def upload_batch(self, request):
        if request.requests:
            for response in self.store.BatchUpdateBlobs(request).responses:
                assert response.status.code == 0, response.status.message

    @staticmethod
    def parts(digest, data):
        name = "uploads/%s/blobs/%s/%d" % (uuid.uuid4(), digest.hash, len(data))
        for start in range(0, len(data), LARGE):
            part = data[start : start + LARGE]
            end = start + len(part) == len(data)
            yield bytestream_pb2.WriteRequest(resource_name=name, write_offset=start, data=part, finish_write=end)


def lay_out(store, digest, folder):
    """Writes a tree of input files."""
    folder.mkdir(parents=True, exist_ok=True)
    directory = api.Directory.FromString(store.read(digest))
    store.fetch([file.digest for file in directory.files])
    for file in directory.files:
        if file.digest.size_bytes:
            shutil.copyfile(store.path(file.digest), folder / file.name)
        else:
            (folder / file.name).touch()
        (folder / file.name).chmod(0o755 if file.is_executable else 0o644)
    store.fetch([below.digest for below in directory.directories])
    for below in directory.directories:
        lay_out(store, below.digest, folder / below.name)


def run(store, action, folder):
    command = api.Command.FromString(store.read(action.command_digest))
    shutil.rmtree(folder, ignore_errors=True)
    lay_out(store, action.input_root_digest, folder)
    for path in command.output_paths:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
    environment = {variable.name: variable.value for variable in command.environment_variables}
    done = subprocess.run(list(command.arguments), cwd=folder, env=environment, stderr=subprocess.PIPE, check=False)
    result, blobs = api.ActionResult(exit_code=done.returncode, stderr_raw=done.stderr), []
    for path in command.output_paths:
        if (folder / path).is_file():
            data = (folder / path).read_bytes()
            digest = api.Digest(hash=hashlib.sha256(data).hexdigest(), size_bytes=len(data))
            blobs.append((digest, data))
            result.output_files.add(path=path, digest=digest)
    store.upload(blobs)
    return result


def main(address, name, folder):
    channel = grpc.insecure_channel(address, options=[("grpc.max_receive_message_length", 16 << 20)])
    grpc.channel_ready_future(channel).result(60)
    print("ready", flush=True)
    bots = bots_pb2_grpc.BotsStub(channel)
    folder = pathlib.Path(folder)
    store = Store(channel, folder / "blobs")
    worker = worker_pb2.Worker(devices=[worker_pb2.Device(handle=name)])
    own = bots_pb2.BotSession(bot_id=name, status=bots_pb2.OK, worker=worker)
    session = bots.CreateBotSession(bots_pb2.CreateBotSessionRequest(parent="", bot_session=own), timeout=8)
    while True:
        for lease in session.leases:
            action = api.Action()
            if not lease.payload.Unpack(action):
                digest = api.Digest()
                lease.payload.Unpack(digest)
                action.ParseFromString(store.read(digest))
            print("lease", lease.id, flush=True)
            lease.result.Pack(run(store, action, folder / "action"))
            lease.state = bots_pb2.COMPLETED
        request = bots_pb2.UpdateBotSessionRequest(name=session.name, bot_session=session)
        session = bots.UpdateBotSession(request, timeout=8)


if __name__ == "__main__":
    os.umask(0o022)
    main(*sys.argv[1:])
