import pytest

from edge.perception.prompts import ENSEMBLE, contrast, ensemble


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
