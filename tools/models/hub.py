"""A model hub: where its files are, and what the environment says about reaching it."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

from models.manifest import ModelError

_ID = re.compile(r"(?P<name>\w[\w.-]*/\w[\w.-]*)(@(?P<revision>[\w./-]+))?", re.ASCII)
# What an import reads: descriptions, and the first of these kinds of weights that is there. Many repositories have the
# same weights for several frameworks.
_DESCRIPTIONS = ["*.json", "*.txt", "*.model", "README.md"]
_WEIGHTS = (
    ["open_clip_*.safetensors"], ["model*.safetensors"], ["open_clip_*.bin"], ["pytorch_model*.bin"],
    [f"*{name}.onnx*" for name in ("image", "vision_model", "visual", "text", "text_model", "textual")],
)  # fmt: skip


@dataclass(frozen=True)
class Repository:
    """``ORGANISATION/NAME`` at a revision (branch, tag or commit)."""

    name: str
    revision: str = "main"

    @classmethod
    def parse(cls, text: str) -> "Repository | None":
        """From ``ORGANISATION/NAME`` or ``ORGANISATION/NAME@REVISION``; None if ``text`` does not look like that."""
        match = _ID.fullmatch(text)
        return cls(match["name"], match["revision"] or "main") if match else None

    def url(self) -> str:
        """Where its files are, without a slash at the end; honours ``HF_ENDPOINT``."""
        return f"{endpoint()}/{self.name}/resolve/{self.revision}"

    def check_online(self) -> None:
        """Raises ModelError when ``HF_HUB_OFFLINE`` forbids to ask the hub."""
        if offline():
            raise ModelError(f"HF_HUB_OFFLINE is set, so {self.name} is not fetched; unset it, or give a folder.")

    def snapshot(self) -> Path:
        """A local folder with the files of the repository that an import may read, from cache or hub.

        Raises:
            ModelError: huggingface_hub is missing, the hub cannot be reached, or has no such repository.
        """
        try:
            from huggingface_hub import snapshot_download
            from huggingface_hub.errors import HfHubHTTPError, LocalEntryNotFoundError
        except ImportError:
            raise ModelError("Reading from a hub needs huggingface-hub: pip install '.[import]'.") from None
        try:
            # The environment is passed on, as huggingface_hub reads it only once, when it is imported.
            environment = {"endpoint": endpoint(), "token": token(), "local_files_only": offline()}
            for kind in _WEIGHTS:
                wanted = {"revision": self.revision, "allow_patterns": [*_DESCRIPTIONS, *kind]}
                folder = Path(snapshot_download(self.name, **wanted, **environment))
                if any(folder.glob(kind[0])):
                    break
            return folder
        except LocalEntryNotFoundError:
            self.check_online()
            raise ModelError(
                f"The hub {endpoint()} cannot be reached and {self.name} is not in the cache; "
                "check the network or HF_ENDPOINT, or give a folder."
            ) from None
        except HfHubHTTPError as error:
            status = getattr(error.response, "status_code", "an error")
            raise ModelError(
                f"The hub {endpoint()} does not give {self} ({status}); check the name, or set HF_TOKEN if private."
            ) from None
        except (OSError, ValueError, TypeError, KeyError) as error:  # the last two from a server that is no hub
            raise ModelError(f"{self} cannot be fetched from {endpoint()}: {_first_line(error)}") from None

    def __str__(self) -> str:
        return self.name if self.revision == "main" else f"{self.name}@{self.revision}"


def endpoint() -> str:
    """The hub's address, without a slash at the end."""
    return (os.environ.get("HF_ENDPOINT") or "https://huggingface.co").rstrip("/")


def offline() -> bool:
    """Whether the user has forbidden to ask the hub."""
    return os.environ.get("HF_HUB_OFFLINE", "").upper() in ("1", "ON", "YES", "TRUE")


def token() -> str | None:
    """The user's password for the hub."""
    return os.environ.get("HF_TOKEN") or None


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]
