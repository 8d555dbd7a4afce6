"""With the import extra only: the exported Grad-CAM is PyTorch's autograd's, whatever the tower."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")
onnxruntime = pytest.importorskip("onnxruntime")
pytest.importorskip("onnx")
pytest.importorskip("open_clip")
pytest.importorskip("timm")

from torch import nn  # noqa: E402
from torch.nn import functional  # noqa: E402

from models.manifest import ModelError  # noqa: E402
from tools.models.export import export_graph  # noqa: E402
from tools.models.grad_cam import export_saliency  # noqa: E402
from tools.models.tower import Tower  # noqa: E402

pytestmark = pytest.mark.filterwarnings("default")


def open_clip_vit():
    from open_clip.transformer import VisionTransformer

    visual = VisionTransformer(image_size=64, patch_size=16, width=48, layers=3, heads=4, mlp_ratio=2.0, output_dim=24)
    return visual, visual.transformer.resblocks[-1], 64


def open_clip_resnet():
    from open_clip.modified_resnet import ModifiedResNet

    visual = ModifiedResNet(layers=[1, 1, 1, 1], output_dim=24, heads=4, image_size=96, width=8)
    return visual, visual.attnpool, 96


def pooled_cnn():
    import timm

    visual = timm.create_model("fastvit_t8", num_classes=24)
    return visual, visual.head, 64


def cnn_with_a_late_convolution():
    import timm

    visual = timm.create_model("mobilenetv3_small_050", num_classes=24)
    return visual, visual.global_pool, 96


def siglip():
    import timm

    visual = timm.create_model(
        "vit_base_patch16_siglip_224", img_size=64, embed_dim=48, depth=2, num_heads=4, num_classes=24
    )
    for module in visual.modules():
        if hasattr(module, "fused_attn"):
            module.fused_attn = False
    return visual, visual.blocks[-1], 64


def vit_with_registers():
    import timm

    visual = timm.create_model(
        "vit_small_patch14_reg4_dinov2", img_size=56, embed_dim=48, depth=2, num_heads=4, num_classes=24
    )
    return visual, visual.blocks[-1], 56


KINDS = {
    open_clip_vit: [(1, 48, 4, 4), (1, 48, 1, 1)],
    open_clip_resnet: [(1, 256, 3, 3)],
    pooled_cnn: [(1, 768, 2, 2)],
    cnn_with_a_late_convolution: [(1, 288, 3, 3)],
    siglip: [(1, 48, 4, 4)],
    vit_with_registers: [(1, 48, 4, 4), (1, 48, 1, 5)],
}


@pytest.fixture(params=KINDS, ids=lambda make: make.__name__)
def tower(request):
    torch.manual_seed(0)
    visual, cut, size = request.param()
    for parameter in visual.parameters():  # fresh ones are often zeros or ones, which would hide mistakes
        nn.init.normal_(parameter, std=0.2 if parameter.dim() == 1 else parameter.shape[-1] ** -0.5)
    tower = Tower(visual.eval().requires_grad_(False), visual, cut, (size, size))
    assert tower.shapes == KINDS[request.param]
    return tower


def pictures(tower, count=3):
    generator = torch.Generator().manual_seed(1)
    return [torch.randn(1, 3, *tower.size, generator=generator) for _ in range(count)]


def autograd_cam(tower, image, direction):
    """Grad-CAM by autograd through the whole model, caught where its own modules meet, patches alone shown."""
    caught = []

    def keep(module, arguments):
        caught.append(arguments[0].detach().requires_grad_())
        return (caught[0], *arguments[1:])

    hook = tower._cut[0].register_forward_pre_hook(keep)
    vector = functional.normalize(tower.model(image), dim=-1)[0]
    hook.remove()
    (vector @ direction).backward()
    features, gradient = caught[0].detach()[0], caught[0].grad[0]
    if features.dim() == 2:  # tokens (n + side * side, C)
        side = tower.shapes[0][2]
        features, gradient = (t[len(t) - side * side :].T.reshape(-1, side, side) for t in (features, gradient))
    weights = gradient.mean((1, 2), keepdim=True) * gradient[0].numel()
    return torch.relu((weights * features).sum(0)).numpy()


def test_a_tower_is_its_model(tower):
    for image in pictures(tower):
        vector, *maps = tower(image)
        expected = functional.normalize(tower.model(image), dim=-1)
        torch.testing.assert_close(vector, expected)
        torch.testing.assert_close(tower.tail(*maps), expected)


def test_the_exported_graphs_give_autograds_grad_cam(tower, tmp_path):
    export_graph(tower, (torch.zeros(1, 3, *tower.size),), tmp_path / "i.onnx", ["image"], ["vectors", *tower.names])
    export_saliency(tower, tmp_path / "s.onnx")
    image_graph = onnxruntime.InferenceSession(tmp_path / "i.onnx")
    saliency_graph = onnxruntime.InferenceSession(tmp_path / "s.onnx")
    peaks = []
    for i, image in enumerate(pictures(tower)):
        direction = torch.randn(tower.dim, generator=torch.Generator().manual_seed(i))
        expected = autograd_cam(tower, image, direction)
        _, *maps = image_graph.run(None, {"image": image.numpy()})
        (found,) = saliency_graph.run(None, dict(zip(tower.names, maps)) | {"direction": direction.numpy()})
        peaks.append(expected.max())
        np.testing.assert_allclose(found, expected, atol=1e-4 * max(peaks), rtol=0)
    assert max(peaks) > 0


def test_a_tail_without_a_form_is_told_in_a_sentence(tmp_path):
    tail = nn.Sequential(nn.ConvTranspose2d(4, 8, 3), nn.AdaptiveAvgPool2d(1), nn.Flatten())
    visual = nn.Sequential(nn.Conv2d(3, 4, 3, 2), tail).eval().requires_grad_(False)
    tower = Tower(visual, visual, tail, (16, 16))
    with pytest.raises(ModelError, match="choose another"):
        export_saliency(tower, tmp_path / "saliency.onnx")
