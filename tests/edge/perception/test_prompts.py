import numpy as np
import pytest

from edge.perception.prompts import ENSEMBLE, EVERYDAY, SOMETHING_ELSE, Target, contrast, ensemble


def test_the_contrast_is_that_of_eq_2():
    assert contrast("teddy bear") == ("A photo of teddy bear", "A photo of something else")


def test_the_ensemble_names_the_object_seven_times():
    prompts = ensemble("  red   chair ")
    assert len(set(prompts)) == len(ENSEMBLE) == 7
    assert all("red chair" in prompt and "{" not in prompt for prompt in prompts)


def test_braces_in_a_name_are_no_format():
    assert contrast("{}{0}")[0] == "A photo of {}{0}"


@pytest.mark.parametrize("make", [contrast, ensemble])
@pytest.mark.parametrize("name", ["", "  \n\t"])
def test_an_empty_name_is_refused(make, name):
    with pytest.raises(ValueError, match="object's name is empty"):
        make(name)


def test_a_target_knows_its_prompts_and_what_else_it_may_be():
    class Rows:
        """Encodes a prompt as its number in the order asked."""

        def encode_text(self, texts):
            self.texts = texts
            return np.arange(len(texts), dtype=np.float32)[:, None]

    encoder = Rows()
    target = Target.of(" lamp ", encoder)
    assert encoder.texts[:3] == ["A photo of lamp", SOMETHING_ELSE, f"A photo of {EVERYDAY[0]}"]
    assert target.name == "lamp" and target.direction == [-1.0]
    assert target.others[:2].tolist() == [[1.0], [2.0]] and len(target.others) == len(EVERYDAY) + 1
    assert len(set(EVERYDAY)) == len(EVERYDAY)
