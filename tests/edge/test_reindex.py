import cv2
import numpy as np

from edge.memory.store import Vlpg
from edge.perception.encoder import Encoder
from edge.reindex import reindex_store


def test_a_store_answers_for_the_shipped_encoder_afterwards(tmp_path):
    rgb = np.zeros((240, 320, 3), np.uint8)
    rgb[60:180, 80:240] = 200, 40, 40
    jpeg = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()
    path = tmp_path / "home.vlpg"
    with Vlpg.open(path, "someone-elses", "0" * 64, 8) as store:
        for x, keyframe in ((0.0, jpeg), (5.0, None)):
            store.add(x, (x, 0.0, 0.0), np.eye(3), np.eye(8)[:1], np.zeros(1), keyframe)

    name, nodes = reindex_store(path, None)

    encoder = Encoder.load(text=False)
    assert name == encoder.name
    assert (nodes.embedded, nodes.withdrawn) == (1, 1)
    view = encoder.encode_image(cv2.cvtColor(cv2.imdecode(np.frombuffer(jpeg, np.uint8), 1), cv2.COLOR_BGR2RGB))
    with Vlpg.open(path, encoder.name, encoder.digest, encoder.dim) as store:
        hits = store.search(view.vectors[0], 1)
        assert hits.scores[0] > 0.98  # int8 rounding
