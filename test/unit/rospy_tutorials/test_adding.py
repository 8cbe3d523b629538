"""The command line of the clients of add_two_ints."""
import pytest

from rospy_tutorials.adding import numbers


@pytest.mark.parametrize('arguments, expected', [
    (['3', '4'], (3, 4)), (['-3', '+4'], (-3, 4)),
    (['9223372036854775807', '-9223372036854775808'], (2 ** 63 - 1, -2 ** 63))])
def test_numbers(arguments, expected):
    assert numbers(arguments) == expected


def test_random_numbers_without_any():
    assert all(-50000 <= number <= 50000 for number in numbers([]))


@pytest.mark.parametrize('arguments, said', [
    (['3'], 'it takes two numbers, or none; there are 1'), (['1', '2', '3'], 'there are 3'),
    (['3', 'four'], "'four' is not a whole number"), (['3', '1.5'], "'1.5' is not"), (['', '1'], "'' is not"),
    (['9223372036854775808', '0'], 'is not a whole number from -9223372036854775808 to 9223372036854775807'),
    (['--3', '1'], "'--3' is not a whole number")])
def test_what_is_no_number_is_named(arguments, said):
    with pytest.raises(ValueError, match=said):
        numbers(arguments)
