from tools.eval.tour import names_in_view, nouns


def test_a_tour_has_everything_in_view(tour):
    assert tour.mapped.complete
    assert tour.in_view == {"teddy bear", "couch", "armchair", "dustbin"}
    assert nouns(tour.world.house) == sorted(tour.in_view)


def test_what_is_removed_is_not_in_view(tour):
    shown = names_in_view(tour.world)
    assert shown <= tour.in_view and len(shown) < 4
