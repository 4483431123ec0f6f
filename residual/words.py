"""Numbers and names as words."""


def text(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits and a true minus sign."""
    plain = f"{value:.{digits}g}"
    if "e" in plain:
        mantissa, exponent = plain.split("e")
        plain = f"{mantissa}·10^{int(exponent)}"
    return plain.replace("-", "−")


def words(name: str) -> str:
    """Write the name of a budget's term as words."""
    return name.replace("_", " ")
